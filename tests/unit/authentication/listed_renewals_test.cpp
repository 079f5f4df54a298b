// What a renewal list may contain, and which of its certificates count.
#include "plugins/authentication/listed_renewals.hpp"

#include <cstring>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/listed.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication::listed {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(Listed, TheOneThatEndsLast_Counts) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s}), renewed_bob(),
               renewed_bob(1, {kNow + 6s, kNow + 41s})}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(plugin()->next_expiry(), kNext.not_after);
}

TEST_F(Listed, AnotherKey_IsNotProven) {
  put(list_of({renewed_bob(7)}));
  expect_ends("another key");
}

TEST_F(Listed, AnotherKindOfKey_IsNotProven) {
  const auto p384 = make_identity(test_ca(), kBob, {KeyKind::ec_p384, 384}, kNext);
  put(list_of({p384.certificate}));
  expect_ends("another key");
}

TEST_F(Listed, AnotherSubjectWithTheKey_HelpsNotAtAll) {
  put(list_of({bob_with(kNext, 1, test_ca(), "CN=bobby,O=Example").certificate}));
  expect_ends("");
}

TEST_F(Listed, ACertificateThatBeginsEarlier_IsAReplay) {
  put(list_of({renewed_bob(1, {kNow - 48h, kNow + 24h})}));
  expect_ends("begins before");
}

TEST_F(Listed, ACertificateThatBeginsInTheFuture_DoesNotCountYet) {
  put(list_of({renewed_bob(1, {kNow + 1h, kNow + 24h})}));
  expect_ends("not valid yet");
}

class ListedWithCrl : public Listed {
 protected:
  ListedWithCrl() : Listed(pem({})) {}
  void revoke(std::vector<pki::Certificate> certificates, std::uint64_t number = 2) {
    folder_.replace("crl.pem", pem({.number = number, .revoked = std::move(certificates)}));
  }
};

TEST_F(ListedWithCrl, ARevokedLaterCertificate_DoesNotCount) {
  const auto later = renewed_bob();
  revoke({later});
  put(list_of({later, renewed_bob(7)}));
  expect_ends("another key");
}

TEST_F(ListedWithCrl, ARevokedOneAlone_IsARefusedList) {
  const auto later = renewed_bob();
  revoke({later});
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::renewal_list_refused));
}

TEST_F(ListedWithCrl, ARevocationAfterTheList_CountsAtOnce) {
  const auto later = renewed_bob();
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  codes();
  revoke({later});
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::certificate_revoked));
}

TEST_F(ListedWithCrl, ARevocationOfTheFirstCertificate_EndsAPeerThatIsKept) {
  put(list_of({renewed_bob()}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  revoke({bob_.certificate});
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::certificate_revoked));
}

// The list was made before the revocation, and an attacker puts it back after it.
TEST_F(ListedWithCrl, AReplayedList_BringsNoRevokedPeerBack) {
  const auto later = renewed_bob();
  revoke({later, bob_.certificate});
  EXPECT_THAT(poll(), ElementsAre(bob_at_alice()));
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_CODE(pairing_.a.discover(pairing_.b), certificate_revoked);
}

class BadList : public Listed {
 protected:
  void SetUp() override {
    Listed::SetUp();
    put(list_of({renewed_bob()}));
    poll();
    EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  }
  // Expects that the list changes nothing, and that one event says what is wrong.
  void expect_refused(std::string_view why) {
    EXPECT_THAT(pass_the_end(), IsEmpty());
    std::vector<Event> refusals;
    for (const auto& event : events())
      if (event.error.code() == Code::renewal_list_refused) refusals.push_back(event);
    ASSERT_EQ(refusals.size(), 1u);
    const auto& error = refusals.front().error;
    EXPECT_EQ(error.details().document, path());
    EXPECT_THAT(error.to_sentence(), HasSubstr(why));
    EXPECT_THAT(error.to_sentence(), HasSubstr("the list read before stays in force"));
    EXPECT_THAT(codes(), Contains(Code::peer_renewal_listed));
  }
  void remove() { ::unlink(path().c_str()); }
};

TEST_F(BadList, Garbage_IsRefused) {
  put("garbage");
  expect_refused("at least one entry");
}

TEST_F(BadList, EmptyFile_IsRefused) {
  put("");
  expect_refused("empty");
}

TEST_F(BadList, MissingFile_IsRefused) {
  remove();
  expect_refused("the file does not exist");
}

TEST_F(BadList, Folder_IsRefused) {
  remove();
  ::mkdir(path().c_str(), 0700);
  expect_refused("expected a regular file");
}

TEST_F(BadList, Socket_IsRefused) {
  remove();
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  expect_refused("the file cannot be read");
  ::close(socket);
}

TEST_F(BadList, FileCutShort_IsRefused) {
  const auto text = list_of({renewed_bob(), bob_.certificate});
  put(text.substr(0, text.size() - 100));
  expect_refused("cut short");
}

TEST_F(BadList, ForeignBlock_IsRefused) {
  put(list_of({renewed_bob()}) + pem_text(bob_.key));
  expect_refused("a block PRIVATE KEY");
}

TEST_F(BadList, Gigabytes_AreRefused) {
  remove();
  put("");
  ASSERT_EQ(::truncate(path().c_str(), off_t{4} << 30), 0);
  expect_refused("the file is larger than any such document may be");
}

TEST_F(BadList, ThousandsOfEntries_AreRefused) {
  std::string text;
  for (std::size_t i = 0; i <= pki::kMaxRenewals; ++i) text += bob_.certificate.pem();
  put(text);
  expect_refused("at most 1024 certificates");
}

TEST_F(BadList, EntryOfAnotherCa_IsRefused) {
  const auto other = make_ca("CN=Other CA,O=Example");
  put(list_of({bob_with(kNext, 1, other).certificate}));
  expect_refused("CN=Identity CA,O=Example");
}

// The certificate in the list is of a CA of the same name.
TEST_F(BadList, EntryOfACaOfTheSameName_IsRefused) {
  const auto other = make_ca();
  put(list_of({bob_with(kNext, 1, other).certificate}));
  expect_refused("no configured CA issued the certificate");
}

TEST_F(Listed, EntriesOfAnotherCa_AreCountedAndPassedOver) {
  const auto other = make_ca("CN=Other CA,O=Example");
  put(list_of({bob_with(kNext, 1, other).certificate, renewed_bob()}));
  poll();
  ASSERT_EQ(events().size(), 1u);
  EXPECT_THAT(events().front().error.details().note, HasSubstr("1 more certificates do not count"));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(Listed, TheRecord_HasTheListAndWhatWasRefused) {
  put(list_of({renewed_bob()}));
  poll();
  const auto taken = plugin().documents.to_json();
  EXPECT_THAT(taken, HasSubstr("renewal list"));
  EXPECT_THAT(taken, HasSubstr(path()));
  EXPECT_THAT(taken, HasSubstr(to_string(kNext.not_after)));
  put("garbage");
  poll();
  poll();
  EXPECT_THAT(plugin().documents.to_json(), HasSubstr("renewal_list_refused"));
}

TEST(ListedPlace, PlaceInTheProperty_IsReadInsteadOfTheUsualOne) {
  const test::TemporaryFolder folder;
  auto identity = make_identity(test_ca(), kAlice);
  set(identity.properties, property::kRenewalList,
      "file:" + folder.write("list.pem", list_of({renewed_bob()})));
  Pairing pairing(identity, bob_with(kShort));
  pairing.expect_success();
  pairing.first_plugin.clock.advance(20s);
  EXPECT_THAT(pairing.first_plugin->poll(), IsEmpty());
}

TEST(ListedPlace, UriThatNamesNoFile_IsRefused) {
  auto identity = make_identity(test_ca(), kAlice);
  set(identity.properties, property::kRenewalList, "data:,x");
  TestPlugin plugin;
  EXPECT_CODE(plugin->validate_local_identity(0, identity.properties, candidate(1)),
              invalid_property);
}

}  // namespace
}  // namespace ddssec::authentication::listed
