// The folder of trusted CAs, whose files change while a participant runs.
#include "plugins/authentication/trusted_folder.hpp"

#include <filesystem>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const pki::Authority& bobs_ca() {
  static const auto ca = make_ca("CN=CA of Bob,O=Example");
  return ca;
}
const pki::Authority& carols_ca() {
  static const auto ca = make_ca("CN=CA of Carol,O=Example");
  return ca;
}
std::string pem_of(const pki::Authority& ca) { return ca.certificate().pem(); }

Identity trusting_all(Identity identity) {
  set(identity.properties, property::kIdentityCa,
      "data:," + pem_of(test_ca()) + pem_of(bobs_ca()) + pem_of(carols_ca()));
  return identity;
}

// Alice trusts the CAs of the folder: her own and Bob's.
class TrustedFolderTest : public testing::Test {
 protected:
  TrustedFolderTest()
      : pairing_(alice(),
                 trusting_all(make_identity(bobs_ca(), "CN=bob,O=Example", {}, kYear, 1))) {
    pairing_.expect_success();
    events().clear();
  }

  Identity alice() const {
    folder_.write("alice.pem", pem_of(test_ca()));
    folder_.write("bob.pem", pem_of(bobs_ca()));
    auto identity = make_identity(test_ca(), "CN=alice,O=Example");
    set(identity.properties, property::kTrustedCaDir, folder_.path());
    return identity;
  }
  // True if Carol authenticates with Alice.
  bool meets_carol() {
    TestPlugin other{7};
    Participant carol(other,
                      trusting_all(make_identity(carols_ca(), "CN=carol,O=Example", {}, kYear, 2)),
                      ++carols_);
    Two two(pairing_.a, carol);
    return Pairing::authenticate(two);
  }
  void remove(const std::string& name) const {
    ASSERT_TRUE(std::filesystem::remove(folder_.path() + "/" + name));
  }
  std::vector<Code> codes_after_looking() { return plugin().codes_after_looking(); }
  // The folder is not taken, this is reported once, and the session with Bob goes on.
  void expect_refused(std::string_view why) {
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewal_refused));
    ASSERT_FALSE(events().empty());
    EXPECT_EQ(events().front().error.details().document, folder_.path());
    EXPECT_THAT(events().front().error.to_sentence(), HasSubstr(why));
    EXPECT_THAT(plugin().ended, IsEmpty());
    EXPECT_EQ(state_of_cas()["refused"]["name"], "identity_ca_renewal_refused");
    EXPECT_EQ(state_of_cas()["state"], "refused");
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "reported twice";
    EXPECT_THAT(plugin().ended, IsEmpty());
  }
  nlohmann::json state_of_cas() {
    const auto all = nlohmann::json::parse(plugin().documents.to_json());
    for (const auto& document : all["participants"][0]["documents"])
      if (document["kind"] == "identity CA") return document;
    ADD_FAILURE() << all.dump();
    return {};
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }
  std::vector<Event>& events() { return plugin().events.all; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }

  const test::TemporaryFolder folder_;
  Pairing pairing_;
  std::uint8_t carols_ = 10;
};

TEST_F(TrustedFolderTest, CaThatIsAdded_CountsForTheNextHandshake) {
  EXPECT_FALSE(meets_carol());
  folder_.replace("carol.pem", pem_of(carols_ca()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  EXPECT_EQ(events().front().error.details().document, folder_.path());
  EXPECT_THAT(events().front().error.details().found, HasSubstr("CN=CA of Carol"));
  EXPECT_THAT(plugin().ended, IsEmpty());
  EXPECT_TRUE(meets_carol());
  EXPECT_EQ(state_of_cas()["in_force"].size(), 3u);
}

TEST_F(TrustedFolderTest, CaInTheFileOfAnother_CountsToo) {
  folder_.write("bob.pem", pem_of(bobs_ca()) + pem_of(carols_ca()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  EXPECT_TRUE(meets_carol());
}

TEST_F(TrustedFolderTest, CaThatIsRemoved_EndsItsPeers) {
  remove("bob.pem");
  EXPECT_THAT(plugin().poll(), IsEmpty()) << "the file may just be replaced";
  EXPECT_THAT(plugin().poll(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(events().back().error.to_sentence(), HasSubstr(folder_.path()));
  EXPECT_THAT(plugin().events.codes(),
              ElementsAre(Code::identity_ca_renewed, Code::identity_ca_withdrawn));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(TrustedFolderTest, FileThatIsJustReplaced_IsNoEvent) {
  remove("bob.pem");
  EXPECT_THAT(plugin().poll(), IsEmpty());
  folder_.write("bob.pem", pem_of(bobs_ca()));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  folder_.write("bob.pem", pem_of(bobs_ca()).substr(0, 200));
  EXPECT_THAT(plugin().poll(), IsEmpty());
  folder_.write("bob.pem", pem_of(bobs_ca()));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_THAT(plugin().ended, IsEmpty());
}

TEST_F(TrustedFolderTest, FileThatIsNoLongerReadable_KeepsItsCas) {
  folder_.replace("bob.pem", "no certificate");
  expect_refused("bob.pem");
  folder_.replace("bob.pem", pem_of(bobs_ca()));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_EQ(state_of_cas()["state"], "current");
}

TEST_F(TrustedFolderTest, FolderWithoutOurCa_IsRefused) {
  remove("alice.pem");
  expect_refused("not among the trusted");
}

TEST_F(TrustedFolderTest, CaThatComesBack_IsRefusedAsARollBack) {
  folder_.write("carol.pem", pem_of(carols_ca()));
  codes_after_looking();
  remove("carol.pem");
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  folder_.write("carol.pem", pem_of(carols_ca()));
  expect_refused("CN=CA of Carol");
  EXPECT_FALSE(meets_carol());
}

TEST_F(TrustedFolderTest, FolderThatIsGone_KeepsItsCas) {
  std::filesystem::rename(folder_.path(), folder_.path() + ".old");
  expect_refused("cannot be read");
  std::filesystem::rename(folder_.path() + ".old", folder_.path());
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(TrustedFolderTest, TooManyFilesOrCas_KeepWhatWasRead) {
  for (std::size_t i = 0; i < TrustedFolder::kMaxFiles; ++i)
    folder_.write("x" + std::to_string(i), "x");
  expect_refused("at most 1000 files");
  for (std::size_t i = 0; i < TrustedFolder::kMaxFiles; ++i) remove("x" + std::to_string(i));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  std::string many;
  for (std::size_t i = 0; i < TrustedFolder::kMaxAuthorities; ++i) many += pem_of(carols_ca());
  folder_.write("many.pem", many);
  expect_refused("at most 100 certificates");
}

TEST_F(TrustedFolderTest, OtherFiles_AreNoEvent) {
  folder_.write("readme.txt", "no certificate");
  folder_.write("leaf.pem", make_identity(bobs_ca(), "CN=bob,O=Example").certificate.pem());
  std::filesystem::create_directory(folder_.path() + "/more");
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

// A CA that is to issue our own certificate comes into the folder and into the file at once.
TEST(TrustedFolder, OwnCas_MayChangeWithIt) {
  const test::TemporaryFolder trusted;
  const test::TemporaryFolder own;
  auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  trusted.write("alice.pem", pem_of(test_ca()));
  set(identity.properties, property::kTrustedCaDir, "file:" + trusted.path());
  set(identity.properties, property::kIdentityCa,
      "file:" + own.write("identity_ca.pem", pem_of(test_ca())));
  TestPlugin plugin{3};
  Participant alone(plugin, identity, 9);
  plugin.events.all.clear();
  own.replace("identity_ca.pem", pem_of(test_ca()) + pem_of(bobs_ca()));
  trusted.write("bob.pem", pem_of(bobs_ca()));
  EXPECT_THAT(plugin.codes_after_looking(),
              ElementsAre(Code::identity_ca_renewed, Code::identity_ca_renewed));
}

TEST(TrustedFolder, AnUnchangedFolder_IsNotReadAgain) {
  const test::TemporaryFolder folder;
  folder.write("alice.pem", pem_of(test_ca()));
  TrustedFolder trusted(folder.path(), std::chrono::seconds(1));
  const auto first = trusted.read_first();
  ASSERT_OK(first);
  const auto adopt = [](const TrustedFolder::Authorities&) { return Status(); };
  std::chrono::seconds now{0};
  for (int i = 0; i < 3; ++i)
    EXPECT_FALSE(trusted.poll(now += std::chrono::seconds(1), *first, adopt).value());
  // With no CA in force, each reading would adopt the file's.
  EXPECT_FALSE(trusted.poll(now + std::chrono::seconds(1), {}, adopt).value());
  const auto path = folder.path() + "/alice.pem";
  std::filesystem::last_write_time(
      path, std::filesystem::last_write_time(path) + std::chrono::seconds(1));
  EXPECT_TRUE(trusted.poll(now + std::chrono::seconds(2), {}, adopt).value());
}

}  // namespace
}  // namespace ddssec::authentication
