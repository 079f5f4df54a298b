// Loans: which types are flat, how many loans a writer and a reader give, when a loan ends, and
// that readers get the same samples with and without loans.
#include "rtps/dcps/loans.hpp"

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/support/counted_memory.hpp"
#include "tests/support/succeeds.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {

enum class Format : std::int32_t { raw, coded = 7 };

struct Frame {
  std::uint32_t camera = 0;
  Format format = Format::raw;
  std::uint64_t stamp = 5;
  std::array<std::uint8_t, 4097> image{};
  std::array<std::uint8_t, 7> rest{};
};
template <>
struct TypeTraits<Frame> {
  static constexpr std::string_view type_name = "Frame";
  static constexpr auto extensibility = Extensibility::final_type;
  static constexpr std::array<MemberPlace, 5> layout = {
      {{offsetof(Frame, camera), kFlatSize<decltype(Frame::camera)>},
       {offsetof(Frame, format), kFlatSize<decltype(Frame::format)>},
       {offsetof(Frame, stamp), kFlatSize<decltype(Frame::stamp)>},
       {offsetof(Frame, image), kFlatSize<decltype(Frame::image)>},
       {offsetof(Frame, rest), kFlatSize<decltype(Frame::rest)>}}};
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("camera", key(s.camera)), s.format, named("stamp", s.stamp), s.image, s.rest);
  }
};
static_assert(FlatType<Frame>);

// Three octets, so that the payload is padded.
struct Small {
  std::array<std::uint8_t, 3> octets{};
};
template <>
struct TypeTraits<Small> {
  static constexpr std::string_view type_name = "Small";
  static constexpr auto extensibility = Extensibility::final_type;
  static constexpr std::array<MemberPlace, 1> layout = {
      {{offsetof(Small, octets), kFlatSize<decltype(Small::octets)>}}};
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.octets);
  }
};
static_assert(FlatType<Small>);

struct Padded {
  std::uint32_t first = 0;
  double second = 0;
};
template <>
struct TypeTraits<Padded> {
  static constexpr std::string_view type_name = "Padded";
  static constexpr auto extensibility = Extensibility::final_type;
  static constexpr std::array<MemberPlace, 2> layout = {
      {{offsetof(Padded, first), kFlatSize<decltype(Padded::first)>},
       {offsetof(Padded, second), kFlatSize<decltype(Padded::second)>}}};
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.first, s.second);
  }
};
struct Large {
  std::uint32_t id = 0;
  std::array<std::uint8_t, (std::size_t{16} << 20)> octets{};
};
template <>
struct TypeTraits<Large> {
  static constexpr std::string_view type_name = "Large";
  static constexpr auto extensibility = Extensibility::final_type;
  static constexpr std::array<MemberPlace, 2> layout = {
      {{offsetof(Large, id), kFlatSize<decltype(Large::id)>},
       {offsetof(Large, octets), kFlatSize<decltype(Large::octets)>}}};
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.id), s.octets);
  }
};
static_assert(FlatType<Large>);
static_assert(!FlatType<Padded> && !FlatType<Reading>);
static_assert(kFlatSize<bool> == 0 && kFlatSize<std::string> == 0 && kFlatSize<Padded> == 0);

namespace {

using namespace testing;
using test::succeeds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

struct Loans : Polled {
  DataWriter<Frame>& writer = frames(a, reliable());
  DataReader<Frame>& reader = **b.subscriber->create_datareader<Frame>(topic(b), reliable());
  LoanedSamples<Frame> loaned;

  static Topic& topic(End& end) {
    auto* known = end.participant->lookup_topicdescription("Frames");
    return known != nullptr ? *known : **end.participant->create_topic<Frame>("Frames");
  }
  static DataWriter<Frame>& frames(End& end, const Qos& qos) {
    return **end.publisher->create_datawriter<Frame>(topic(end), qos);
  }
  void SetUp() override { ASSERT_TRUE(match(writer, reader)); }
  void write(std::uint32_t camera, std::uint64_t stamp) {
    auto loan = writer.loan();
    ASSERT_TRUE(loan);
    (*loan)->camera = camera;
    (*loan)->stamp = stamp;
    (*loan)->image.back() = 9;
    ASSERT_TRUE(succeeds(writer.write(*std::move(loan))));
    run();
  }
  std::vector<std::uint64_t> stamps() const {
    std::vector<std::uint64_t> out;
    for (const auto& sample : loaned)
      if (sample.info().valid_data) out.push_back(sample->stamp);
    return out;
  }
};

TEST_P(Loans, FilledInPlace_ArriveAtBothKindsOfReads) {
  write(1, 10);
  Samples<Frame> copied;
  ASSERT_EQ(reader.read(copied), 1u);
  EXPECT_EQ(copied[0].data.camera, 1u);
  EXPECT_EQ(copied[0].data.stamp, 10u);
  EXPECT_EQ(copied[0].data.image.back(), 9);
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_EQ(loaned[0].info().sample_state, SampleState::read);
  EXPECT_EQ(loaned[0]->stamp, 10u);
  EXPECT_EQ(loaned[0].data().image.back(), 9);
  EXPECT_EQ(reader.take(loaned), 0u);
  EXPECT_TRUE(loaned.empty());
}

// What is written from a loan is octet for octet what is written by copying.
TEST_P(Loans, PayloadOfALoan_IsThatOfACopy) {
  auto& small = **a.publisher->create_datawriter<Small>(
      **a.participant->create_topic<Small>("Small"), reliable());
  auto& octets =
      **b.subscriber->create_datareader(**b.participant->create_topic<Small>("Small"), reliable());
  ASSERT_TRUE(match(small, octets));
  auto loan = *small.loan_for_overwrite();
  loan->octets = {1, 2, 3};
  ASSERT_TRUE(succeeds(small.write(std::move(loan))));
  ASSERT_TRUE(succeeds(small.write({{1, 2, 3}})));
  run();
  std::vector<OctetSample> raw;
  ASSERT_EQ(octets.take(raw), 2u);
  for (const auto& sample : raw)
    EXPECT_THAT(sample.payload.view(), ElementsAre(0, 1, 0, 1, 1, 2, 3, 0));
}

TEST_P(Loans, FreshLoan_HasTheInitialValues) {
  for (int i = 0; i < 3; ++i) {
    auto loan = *writer.loan();
    EXPECT_EQ(loan->stamp, 5u);
    EXPECT_EQ(std::ranges::count(loan->image, 0), 4097);
    loan->stamp = 77;
    loan->image.fill(0xaa);
  }
}

class LoansOfOneProcess : public Loans {};

TEST_P(LoansOfOneProcess, Loan_IsReadWhereItWasFilled) {
  auto loan = *writer.loan();
  const auto* const place = &*loan;
  ASSERT_TRUE(succeeds(writer.write(std::move(loan))));
  run();
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_EQ(&loaned[0].data(), place);
}

// The sample that is read is the payload that arrived.
TEST_P(Loans, LoanedSample_IsNotCopied) {
  write(1, 1);
  const auto before = counted_memory::octets_ever();
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_LT(counted_memory::octets_ever() - before, std::int64_t{sizeof(Frame)});
}

TEST_P(Loans, MoreThanTheLimitOfAWriter_AreRefusedUntilOneIsGivenBack) {
  std::vector<WriterLoan<Frame>> held;
  for (std::size_t i = 0; i < AnyDataWriter::kMaxLoans; ++i) held.push_back(*writer.loan());
  const auto refused = writer.loan();
  ASSERT_EQ(code_of(refused), Code::rtps_precondition_not_met);
  EXPECT_THAT(refused.error().to_sentence(), HasSubstr("at most 64"));
  EXPECT_EQ(code_of(writer.loan_octets(8)), Code::rtps_precondition_not_met);
  held.pop_back();
  EXPECT_TRUE(writer.loan());
  ASSERT_TRUE(succeeds(writer.write(std::move(held.back()))));
  EXPECT_FALSE(held.back());
  EXPECT_TRUE(writer.loan());
}

TEST_P(Loans, MoreThanTheLimitOfAReader_AreRefusedUntilSomeAreGivenBack) {
  for (std::uint64_t i = 0; i < AnyDataReader::kMaxLoans + 2; ++i) write(1, i);
  ASSERT_EQ(reader.take(loaned, 1), 1u);
  const auto first = std::move(loaned[0]);
  LoanedSamples<Frame> others;
  EXPECT_EQ(reader.take(others), AnyDataReader::kMaxLoans - 1);
  LoanedSamples<Frame> last;
  const auto refused = reader.take(last);
  ASSERT_EQ(code_of(refused), Code::rtps_precondition_not_met);
  EXPECT_THAT(refused.error().to_sentence(), HasSubstr("at most 256"));
  Samples<Frame> copied;
  EXPECT_EQ(reader.read(copied), 2u);  // copies need no loan
  others.clear();
  EXPECT_EQ(reader.take(last), 2u);
  EXPECT_EQ(first->stamp, 0u);
}

TEST_P(Loans, LoanThatCannotBeWritten_IsStillValid) {
  auto qos = reliable();
  qos.resource_limits.max_instances = 1;
  auto& limited = frames(a, qos);
  auto loan = *limited.loan();
  loan->camera = 1;
  ASSERT_TRUE(succeeds(limited.write(std::move(loan))));
  loan = *limited.loan();
  loan->camera = 2;
  EXPECT_EQ(code_of(limited.write(std::move(loan))), Code::rtps_out_of_resources);
  ASSERT_TRUE(loan);
  loan->camera = 1;
  EXPECT_TRUE(succeeds(limited.write(std::move(loan))));
  EXPECT_FALSE(loan);
}

TEST_P(Loans, LoanOfAnotherWriterOrNone_IsRefused) {
  auto& other = frames(a, reliable());
  auto foreign = *other.loan();
  EXPECT_EQ(code_of(writer.write(std::move(foreign))), Code::rtps_precondition_not_met);
  EXPECT_TRUE(succeeds(other.write(std::move(foreign))));
  EXPECT_EQ(code_of(other.write(std::move(foreign))), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(writer.write(WriterLoan<Frame>())), Code::rtps_precondition_not_met);
}

TEST_P(Loans, WriterAndReaderGone_LoansStayValid) {
  write(1, 3);
  auto loan = *writer.loan();
  ASSERT_EQ(reader.take(loaned), 1u);
  ASSERT_TRUE(succeeds(a.publisher->delete_datawriter(writer)));
  ASSERT_TRUE(succeeds(b.subscriber->delete_datareader(reader)));
  loan->stamp = 4;
  EXPECT_EQ(loaned[0]->stamp, 3u);
}

// Keys, handles and source times are those of the sample in the loan.
TEST_P(Loans, InstancesAndSourceTimes_AreThoseOfTheSample) {
  const auto handle = *writer.register_instance({.camera = 4});
  auto loan = *writer.loan();
  loan->camera = 4;
  EXPECT_EQ(code_of(writer.write(std::move(loan), InstanceHandle{99})), Code::rtps_bad_parameter);
  ASSERT_TRUE(succeeds(writer.write_w_timestamp(std::move(loan), handle, Time{{5, 0}})));
  write(6, 1);
  ASSERT_TRUE(succeeds(writer.dispose({.camera = 4})));
  run();
  ASSERT_EQ(reader.take_instance(loaned, reader.lookup_instance({.camera = 4})), 2u);
  EXPECT_EQ(loaned[0].info().source_timestamp, (Time{{5, 0}}));
  EXPECT_FALSE(loaned[1].info().valid_data);
  EXPECT_EQ(loaned[1].info().instance_state, InstanceState::not_alive_disposed);
  EXPECT_EQ(loaned[1]->camera, 4u);
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_EQ(loaned[0]->camera, 6u);
}

TEST_P(Loans, ConditionsAndFilters_SelectLoanedSamples) {
  auto* low = *b.participant->create_contentfilteredtopic(
      "Low", *b.participant->lookup_topicdescription("Frames"), {"stamp < %0", {"5"}});
  auto& filtered = **b.subscriber->create_datareader<Frame>(*low, reliable());
  ASSERT_TRUE(match(writer, filtered));
  auto& odd = **reader.create_querycondition(States{}, {"stamp = 3 OR stamp = 9", {}});
  for (const std::uint64_t stamp : {3, 4, 9}) write(1, stamp);
  ASSERT_EQ(reader.take_w_condition(loaned, odd), 2u);
  EXPECT_THAT(stamps(), ElementsAre(3, 9));
  ASSERT_EQ(filtered.take(loaned), 2u);
  EXPECT_THAT(stamps(), ElementsAre(3, 4));
}

// In another encoding, both sides convert.
TEST_P(Loans, OtherEncodings_AreConverted) {
  auto qos = reliable();
  qos.data_representation = {DataRepresentation::xcdr2};
  auto& second = frames(a, qos);
  auto reading = reliable();
  reading.data_representation = {DataRepresentation::xcdr1, DataRepresentation::xcdr2};
  auto& both = **b.subscriber->create_datareader<Frame>(topic(b), reading);
  auto& octets = **a.publisher->create_datawriter(topic(a), reliable());
  ASSERT_TRUE(match(second, both));
  ASSERT_TRUE(match(octets, both));
  auto loan = *second.loan();
  loan->stamp = 1;
  ASSERT_TRUE(succeeds(second.write(std::move(loan))));
  EXPECT_FALSE(loan);
  Bytes big, scratch;
  serialize(Frame{.stamp = 2}, big, XcdrVersion::xcdr1, Endian::big);
  ASSERT_TRUE(succeeds(octets.write_octets({.payload = big, .key = key_hash(Frame{}, scratch)})));
  run();
  ASSERT_EQ(both.take(loaned), 2u);
  EXPECT_THAT(stamps(), ElementsAre(1, 2));
}

// A hostile writer's short or cut sample is never read in place.
TEST_P(Loans, MalformedSamples_AreRemovedAndCounted) {
  auto& hostile = **a.publisher->create_datawriter(topic(a), reliable());
  ASSERT_TRUE(match(hostile, reader));
  Bytes whole, scratch;
  serialize(Frame{}, whole);
  const auto key = key_hash(Frame{}, scratch);
  // The network pads to a multiple of 4.
  for (const std::size_t size : {4, 5, 8, 4096, 4119})
    ASSERT_TRUE(
        succeeds(hostile.write_octets({.payload = BytesView(whole).first(size), .key = key})));
  whole[3] = 3;  // says that the last octets are padding
  ASSERT_TRUE(succeeds(hostile.write_octets({.payload = whole, .key = key})));
  run();
  write(0, 8);
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_THAT(stamps(), ElementsAre(8));
  EXPECT_GT(reader.malformed(), 0u);
}

// A newer writer's sample may have more octets. It is copied, so that a loan of a small type does
// not keep all of them. Memory of that size is not kept for the next sample.
TEST_P(LoansOfOneProcess, LongSample_KeepsNoMoreThanOneOfItsType) {
  auto& octets = **a.publisher->create_datawriter(topic(a), reliable());
  ASSERT_TRUE(match(octets, reader));
  Bytes sample, scratch;
  serialize(Frame{.stamp = 12}, sample);
  sample.resize(Payload::kMaxKeptOctets + 1024);
  const auto key = key_hash(Frame{}, scratch);
  std::vector<LoanedSample<Frame>> kept;
  const auto take = [&] {
    ASSERT_TRUE(succeeds(octets.write_octets({.payload = sample, .key = key})));
    run();
    ASSERT_EQ(reader.take(loaned), 1u);
    EXPECT_EQ(loaned[0]->stamp, 12u);
    kept.push_back(std::move(loaned[0]));
    EXPECT_FALSE(loaned[0]) << "it was moved from";
  };
  take();
  const auto before = counted_memory::octets();
  for (int i = 0; i < 3; ++i) take();
  EXPECT_LT(counted_memory::octets() - before, std::int64_t{Payload::kMaxKeptOctets});
}

// Such a sample is refused before memory for a sample of the type is taken. Memory of 16 MiB is not
// kept for the next one.
TEST_P(LoansOfOneProcess, ShortSample_CostsNoSampleOfItsType) {
  auto& topic_of_a = **a.participant->create_topic<Large>("Large");
  auto& topic_of_b = **b.participant->create_topic<Large>("Large");
  auto& honest = **a.publisher->create_datawriter<Large>(topic_of_a, reliable());
  auto& hostile = **a.publisher->create_datawriter(topic_of_a, reliable());
  auto& larges = **b.subscriber->create_datareader<Large>(topic_of_b, reliable());
  ASSERT_TRUE(match(honest, larges));
  ASSERT_TRUE(match(hostile, larges));
  // Of an instance that the reader knows, a sample is not read before it is taken.
  auto loan = honest.loan();
  ASSERT_TRUE(loan);
  Bytes scratch;
  const auto key = key_hash(**loan, scratch);
  ASSERT_TRUE(succeeds(honest.write(*std::move(loan))));
  run();
  LoanedSamples<Large> out;
  ASSERT_EQ(larges.take(out), 1u);
  const Bytes short_sample{0, 1, 0, 0, 0, 0, 0, 0};
  ASSERT_TRUE(succeeds(hostile.write_octets({.payload = short_sample, .key = key})));
  run();
  const auto before = counted_memory::octets_ever();
  EXPECT_EQ(larges.take(out), 0u);
  EXPECT_LT(counted_memory::octets_ever() - before, std::int64_t{1} << 20);
  EXPECT_EQ(larges.malformed(), 1u);
}

// Its values do not fit on the stack of a thread.
TEST_P(LoansOfOneProcess, TypeLargerThanAStack_IsWrittenTakenAndDisposed) {
  const auto topic_of = [](End& end) -> Topic& {
    return **end.participant->create_topic<Large>("Large");
  };
  auto& large = **a.publisher->create_datawriter<Large>(topic_of(a), reliable());
  auto& larges = **b.subscriber->create_datareader<Large>(topic_of(b), reliable());
  ASSERT_TRUE(match(large, larges));
  auto loan = large.loan();
  ASSERT_TRUE(loan);
  (*loan)->id = 7;
  (*loan)->octets.back() = 9;
  ASSERT_TRUE(succeeds(large.write(*std::move(loan))));
  const auto same = std::make_unique<Large>();
  same->id = 7;
  LoanedSamples<Large> out;
  run();
  ASSERT_EQ(larges.take(out), 1u);
  EXPECT_EQ(out[0]->octets.back(), 9);
  ASSERT_TRUE(succeeds(large.dispose(*same)));
  run();
  ASSERT_EQ(larges.take(out), 1u);
  EXPECT_FALSE(out[0].info().valid_data);
  EXPECT_EQ(out[0]->id, 7u);
}

// Octets of any type, with the encapsulation that the application writes.
TEST_P(Loans, LoanOfOctets_IsWrittenWithoutACopy) {
  auto& octets = **a.publisher->create_datawriter(topic(a), reliable());
  ASSERT_TRUE(match(octets, reader));
  EXPECT_EQ(code_of(octets.loan_octets(3)), Code::rtps_bad_parameter);
  EXPECT_EQ(code_of(octets.loan_octets(StatefulReader::kMaxSample + 1)),
            Code::rtps_sample_too_large);
  Bytes sample, scratch;
  serialize(Frame{.stamp = 12}, sample);
  auto loan = *octets.loan_octets(sample.size() + 100);
  EXPECT_EQ(std::ranges::count(loan.octets(), 0), static_cast<int>(sample.size() + 100));
  std::ranges::copy(sample, loan.octets().begin());
  loan.shrink(sample.size());
  EXPECT_EQ(code_of(octets.write_octets(std::move(loan))), Code::rtps_bad_parameter);  // no key
  const auto before = counted_memory::octets_ever();
  ASSERT_TRUE(succeeds(octets.write_octets(std::move(loan), {.key = key_hash(Frame{}, scratch)})));
  EXPECT_LT(counted_memory::octets_ever() - before, std::int64_t{sizeof(Frame)});
  EXPECT_FALSE(loan);
  run();
  ASSERT_EQ(reader.take(loaned), 1u);
  EXPECT_THAT(stamps(), ElementsAre(12));
}

INSTANTIATE_TEST_SUITE_P(Ways, Loans, ::testing::Values(Way::network, Way::in_process),
                         testing::name_of);
INSTANTIATE_TEST_SUITE_P(Over, LoansOfOneProcess, ::testing::Values(Way::in_process),
                         testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
