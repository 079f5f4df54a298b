// Documents of both kinds: whole ones of other projects, parts of documents, and documents that are
// too large.
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

TEST(ReadDocuments, TooManyRules_AreRefused) {
  std::string topics;
  for (std::size_t i = 0; i <= kMaxEntries; ++i) topics += "<topic>a</topic>";
  EXPECT_CODE(permissions_from(replaced(kPermissionsXml, "<topic>Circle</topic>", topics)),
              too_many_rules);
}

TEST(ReadDocuments, EveryPartOfOne_IsRefused) {
  for (std::size_t size = 0; size + 2 < kGovernanceXml.size(); ++size) {
    EXPECT_FALSE(governance_from(std::string_view(kGovernanceXml).substr(0, size))) << size;
  }
  for (std::size_t size = 0; size + 2 < kPermissionsXml.size(); ++size) {
    EXPECT_FALSE(permissions_from(std::string_view(kPermissionsXml).substr(0, size))) << size;
  }
}

TEST(ReadDocuments, FlippedBits_DoNotCrashTheReader) {
  for (std::size_t bit = 0; bit < kPermissionsXml.size() * 8; ++bit) {
    std::string xml = kPermissionsXml;
    xml[bit / 8] = static_cast<char>(xml[bit / 8] ^ (1 << bit % 8));
    const auto document = permissions_from(xml);
    if (!document) {
      EXPECT_NE(document.error().code(), Code::internal);
    }
  }
}

TEST(ReadDocuments, DocumentsOfOtherProjects_AreRead) {
  for (const auto* name : {"cyclonedds/validate_local_permissions/Test_Governance_full.xml",
                           "sros2/upstream/defaults/governance.xml"}) {
    const auto document = read_governance(data_file(name));
    EXPECT_TRUE(document) << document.error().to_sentence();
  }
  for (const auto* name : {"sros2/upstream/permissions/talker_listener/permissions.xml",
                           "sros2/upstream/permissions/add_two_ints/permissions.xml",
                           "sros2/generated/negative/permissions.expired.xml"}) {
    const auto document = read_permissions(data_file(name));
    EXPECT_TRUE(document) << document.error().to_sentence();
  }
}

}  // namespace
}  // namespace ddssec::governance
