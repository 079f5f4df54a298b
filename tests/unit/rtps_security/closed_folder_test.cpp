// A participant whose documents are in a folder that its process can no longer enter.
#include "base/rate_limited_sink.hpp"
#include "pki/renewal_list.hpp"
#include "tests/support/bad_file.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr Rules kRules = everything(ProtectionKind::encrypt);

// All documents of a participant in one folder, which it looks at once a second.
class Folder {
 public:
  spi::PropertyList with_all(spi::PropertyList properties) const {
    namespace property = spi::property;
    const auto& ca = Authorities::shared().identity_ca;
    for (auto& one : properties) {
      const auto file = one.name.substr(one.name.rfind('.') + 1);
      one.value = "file:" + folder_.write(file, one.value.substr(data_uri("").size()));
    }
    const pki::CrlTemplate list{
        .this_update = pki::kNow, .next_update = pki::kNow + 24h, .number = 1};
    folder_.write("crl.pem", ca.make_crl(list)->pem());
    const auto renewed = pki::make_leaf(ca, "CN=carol,O=Example").certificate;
    folder_.write("renewed.pem", pki::RenewalList{.certificates = {renewed}}.text().value());
    properties.push_back({std::string(property::kFilesPollInterval), "1", false});
    return properties;
  }
  void put_certificate(const spi::PropertyList& renewed) const {
    for (const auto name : {spi::property::kPrivateKey, spi::property::kIdentityCertificate})
      folder_.replace(std::string(name.substr(name.rfind('.') + 1)),
                      spi::find_property(renewed, name)->substr(data_uri("").size()));
  }
  std::string path() const { return folder_.path(); }

 private:
  const test::TemporaryFolder folder_;
};

// Both plugins look at files of the folder, and each of them at several.
TEST(FolderThatCloses, WithAllDocuments_IsOneEventAndTheSessionGoesOn) {
  const Folder folder;
  Node a(1, folder.with_all(member("alice", kRules))), b(2, member("bob", kRules));
  World world;
  world.nodes = {&a, &b};
  ASSERT_TRUE(a->create_writer(square(default_writer_qos()), a.listener, world.now));
  ASSERT_TRUE(b->create_reader(square(default_reader_qos()), b.listener, world.now));
  const auto match = [&] { return a.listener.matched == 1 && b.listener.matched == 1; };
  ASSERT_TRUE(world.run_until(match)) << a.events.text();
  const auto look = [&](int times, RateLimitedSink* sink) {
    for (int i = 0; i < times; ++i) {
      const auto before = a.events.all.size();
      for (auto* node : world.nodes) node->clock.advance(1s);
      world.run(250);
      for (auto at = before; sink != nullptr && at < a.events.all.size(); ++at)
        sink->raise(a.events.all[at]);
    }
  };
  look(3, nullptr);
  test::RecordedEvents passed;
  RateLimitedSink limited(passed, a.clock);
  {
    const test::ClosedFolder closed(folder.path());
    look(15, &limited);
  }
  ASSERT_THAT(passed.codes(), ElementsAre(Code::folder_unreadable)) << passed.text();
  EXPECT_EQ(passed.all.front().error.details().document, folder.path());
  EXPECT_TRUE(match()) << a.events.text() << b.events.text();
  EXPECT_EQ(b.events.count(Code::rtps_peer_authenticated), 1) << b.events.text();
  a.events.all.clear();
  look(3, nullptr);
  EXPECT_THAT(a.events.all, IsEmpty()) << a.events.text();
  folder.put_certificate(member("alice", kRules));
  look(3, nullptr);
  EXPECT_TRUE(a.events.has(Code::identity_renewed)) << a.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
