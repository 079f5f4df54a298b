// Values that other products write or read in another way.
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

struct Edit {
  const char* name;
  std::string from, to;
};
void PrintTo(const Edit& edit, std::ostream* out) { *out << edit.name; }

class LenientGovernance : public testing::TestWithParam<Edit> {};
TEST_P(LenientGovernance, EachLeniency_IsReadWithANote) {
  const auto document = governance_from(replaced(kGovernanceXml, GetParam().from, GetParam().to));
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(document->notes.size(), 1u);
}
INSTANTIATE_TEST_SUITE_P(
    Table, LenientGovernance,
    testing::Values(
        Edit{"capitals", "control>true", "control>TRUE"},
        Edit{"number", "control>true", "control>1"},
        Edit{"lower case kind", ">SIGN</liveliness", ">sign</liveliness"},
        Edit{"order",
             "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>\n"
             "      <enable_join_access_control>true</enable_join_access_control>",
             "<enable_join_access_control>true</enable_join_access_control>\n"
             "      "
             "<allow_unauthenticated_participants>false</allow_unauthenticated_participants>"},
        Edit{"only min", "<id>7</id>", "<id_range><min>7</min></id_range>"},
        Edit{"only max", "<id>7</id>", "<id_range><max>7</max></id_range>"}));

class SameGovernance : public testing::TestWithParam<Edit> {};
TEST_P(SameGovernance, EachSpelling_IsReadAlike) {
  const auto document = governance_from(replaced(kGovernanceXml, GetParam().from, GetParam().to));
  ASSERT_TRUE(document) << document.error().to_sentence();
  for (const auto& note : document->notes)
    EXPECT_THAT(note.kind, testing::AnyOf(NoteKind::passed_over, NoteKind::other_attribute))
        << note.text;
  EXPECT_EQ(document->domain_rules[0].domains.ranges.front(), (DomainRange{7, 7}));
  EXPECT_EQ(document->domain_rules[0].topic_rules[0].topic_expression, "Square*");
}
INSTANTIATE_TEST_SUITE_P(
    Table, SameGovernance,
    testing::Values(Edit{"blanks", "<id>7</id>", "<id>\n 7\t</id>"},
                    Edit{"CDATA", ">Square*<", "><![CDATA[Square*]]><"},
                    Edit{"character number", ">Square*<", ">&#83;quare&#x2a;<"},
                    Edit{"may be ignored", "<domains>",
                         "<new must_interpret=\"FALSE\" x=\"y\"><a><b/></a></new><domains>"},
                    Edit{"attribute may be ignored", "<topic_rule>",
                         "<topic_rule must_interpret=\"false\" future=\"1\">"},
                    Edit{"at the top", "<domain_access_rules>",
                         "<extra must_interpret=\"0\"/><domain_access_rules>"},
                    Edit{"must be interpreted, and is", "<domains>",
                         "<domains must_interpret=\"true\">"}));

}  // namespace
}  // namespace ddssec::governance
