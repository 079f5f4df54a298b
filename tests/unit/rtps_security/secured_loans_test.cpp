// Loans between secured participants, by the network and by shared memory: the same samples with
// each protection, and none is converted.
#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps_security/secured_dcps.hpp"
#include "tests/unit/rtps_security/shared_memory_fixture.hpp"

namespace ddssec::rtps {

struct Picture {
  std::uint64_t number = 0;
  std::array<std::uint32_t, 16 << 10> pixels{};
};
template <>
struct TypeTraits<Picture> {
  static constexpr std::string_view type_name = "Picture";
  static constexpr auto extensibility = Extensibility::final_type;
  static constexpr std::array<MemberPlace, 2> layout = {
      {{offsetof(Picture, number), kFlatSize<decltype(Picture::number)>},
       {offsetof(Picture, pixels), kFlatSize<decltype(Picture::pixels)>}}};
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("number", s.number), s.pixels);
  }
};

namespace {

using namespace testing;

struct LoanCase {
  const char* name;
  ProtectionKind data;
  const char* shared_memory;
};
void PrintTo(const LoanCase& it, std::ostream* out) { *out << it.name; }

struct SecuredLoans : ::testing::TestWithParam<LoanCase> {
  ManualClock clock{pki::kNow};
  SecuredProcess alice{clock}, bob{clock};
  std::unique_ptr<DomainParticipant> a = joined(alice, "CN=alice,O=Example"),
                                     b = joined(bob, "CN=bob,O=Example");
  DataWriter<Picture>& writer = **a->create_publisher().create_datawriter<Picture>(
      **a->create_topic<Picture>("Pictures"), reliable());
  DataReader<Picture>& reader = **b->create_subscriber().create_datareader<Picture>(
      **b->create_topic<Picture>("Pictures"), reliable());
  LoanedSamples<Picture> loaned;

  static Qos reliable() {
    auto qos = default_writer_qos();
    qos.history = {HistoryKind::keep_last, 4};
    return qos;
  }
  std::unique_ptr<DomainParticipant> joined(SecuredProcess& process, const char* subject) const {
    auto options = process.options(subject, {.data = GetParam().data});
    options.delivers_in_process = false;
    auto& properties = options.security->properties;
    for (auto& property : shm(GetParam().shared_memory)) properties.push_back(property);
    return DomainParticipant::create(std::move(options), process.services).value();
  }
  bool eventually(const std::function<bool()>& done) {
    for (int i = 0; i < 500 && !done(); ++i) {
      clock.advance(std::chrono::milliseconds(10));
      for (int n = 0; n < 4; ++n) a->poll({}), b->poll({});
    }
    return done();
  }
  void write_and_read(std::uint64_t number) {
    auto picture = *writer.loan();
    picture->number = number;
    picture->pixels.fill(static_cast<std::uint32_t>(number * 3));
    ASSERT_TRUE(writer.write(std::move(picture)));
    ASSERT_TRUE(eventually([&] { return wait_for_samples(reader, {}, {}); })) << number;
    const auto before = counted_memory::octets_ever();
    ASSERT_EQ(reader.take(loaned), 1u);
    EXPECT_LT(counted_memory::octets_ever() - before, std::int64_t{sizeof(Picture)});
    EXPECT_EQ(loaned[0]->number, number);
    EXPECT_EQ(std::ranges::count(loaned[0]->pixels, number * 3), 16 << 10);
  }
};

TEST_P(SecuredLoans, Pictures_AreReadWhereTheyArrived) {
  ASSERT_TRUE(eventually([&] {
    return writer.matched_subscription_data(reader.guid()) &&
           reader.matched_publication_data(writer.guid());
  })) << alice.events.text();
  // A thread prepares the memory meanwhile.
  const bool is_on = GetParam().shared_memory == std::string_view("on");
  std::uint64_t number = 0;
  const auto is_used = [&] { return alice.events.has(Code::rtps_memory_used); };
  for (; number < (is_on ? 1000 : 10) && !is_used() && !HasFatalFailure(); ++number) {
    write_and_read(number);
    a->poll(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(is_used(), is_on) << alice.events.text();
  for (const auto end = number + 10; number < end && !HasFatalFailure(); ++number)
    write_and_read(number);
}

using enum ProtectionKind;

INSTANTIATE_TEST_SUITE_P(Ways, SecuredLoans,
                         ::testing::Values(LoanCase{"memory_open", none, "on"},
                                           LoanCase{"memory_signed", sign, "on"},
                                           LoanCase{"memory_encrypted", encrypt, "on"},
                                           LoanCase{"network_encrypted", encrypt, "off"}),
                         [](const auto& it) { return std::string(it.param.name); });

}  // namespace
}  // namespace ddssec::rtps
