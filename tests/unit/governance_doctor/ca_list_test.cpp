// The lists of CAs that are near a participant's folder.
#include "governance/doctor/ca_list.hpp"

#include <gtest/gtest.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

class CaListTest : public Folders {
 protected:
  CaListTest() : folder_(participant("talker")) { fs::create_directories(file_.parent_path()); }

  static pki::Crl list(std::uint64_t number, const pki::Authority& ca) {
    return *ca.make_crl({.this_update = ca.certificate().not_before(),
                         .next_update = ca.certificate().not_after(),
                         .number = number,
                         .entries = {}});
  }
  std::optional<CaList> newer() const {
    return newer_ca_list(folder_, {identity_ca_.certificate()}, own_);
  }
  std::optional<CaList> outdated() const {
    return outdated_ca_list(folder_, {identity_ca_.certificate()}, own_);
  }

  const pki::ParticipantFolder folder_;
  // Where `init` puts the list of its identity CA.
  const fs::path file_ = root_ / "ca" / "identity" / "crl.pem";
  const std::vector<pki::Crl> own_{list(2, identity_ca_)};
};

TEST_F(CaListTest, AListWithAHigherNumber_IsNewer) {
  write(file_, list(3, identity_ca_).pem());
  const auto found = newer();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->list.number(), 3u);
  EXPECT_EQ(fs::canonical(found->file), fs::canonical(file_));
  EXPECT_FALSE(outdated());
}

TEST_F(CaListTest, TheSameNumber_IsNeitherNewerNorOutdated) {
  write(file_, list(2, identity_ca_).pem());
  EXPECT_FALSE(newer());
  EXPECT_FALSE(outdated());
}

TEST_F(CaListTest, ALowerNumber_IsOutdated) {
  write(file_, list(1, identity_ca_).pem());
  EXPECT_FALSE(newer());
  const auto found = outdated();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->list.number(), 1u);
}

TEST_F(CaListTest, AListOfAnotherCa_IsLeftOut) {
  const auto other = make_ca("CN=Identity CA");
  write(file_, list(9, other).pem());
  EXPECT_FALSE(newer());
  EXPECT_FALSE(outdated());
}

TEST_F(CaListTest, AKeystoreThatTheCaIsALinkInto_IsLookedAt) {
  const auto keystore = root_ / "elsewhere" / "public";
  fs::create_directories(keystore);
  fs::rename(folder_.identity_ca, keystore / "identity_ca.cert.pem");
  fs::create_symlink(keystore / "identity_ca.cert.pem", folder_.identity_ca);
  write(keystore / "identity_ca.crl.pem", list(3, identity_ca_).pem());
  EXPECT_TRUE(newer());
}

TEST_F(CaListTest, TheHighestNumberOfAllPlaces_IsTaken) {
  write(file_, list(3, identity_ca_).pem());
  fs::create_directories(root_ / "public");
  write(root_ / "public" / "identity_ca.crl.pem", list(5, identity_ca_).pem());
  write(root_ / "ca" / "crl.pem", list(4, identity_ca_).pem());
  const auto found = newer();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->list.number(), 5u);
}

TEST_F(CaListTest, NoList_OrNoFile_IsLeftOut) {
  EXPECT_FALSE(newer());
  write(file_, "no list");
  EXPECT_FALSE(newer());
  fs::remove(file_);
  fs::create_directory(file_);
  EXPECT_FALSE(newer());
}

}  // namespace
}  // namespace ddssec::governance::doctor
