// The effect of each element of governance on the verdict when its value rises or falls.
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "governance/compare/governance_diff.hpp"
#include "tests/unit/governance_compare/documents.hpp"

namespace ddssec::governance {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;
using enum ChangeClass;

// One row of the table of elements: what raises one value, and the class of this change.
struct Row {
  const char* element;
  std::function<void(DomainRule&)> raise;
  ChangeClass up = stronger;
  ChangeClass down = weaker;
  Interop interop = Interop::endpoint;
  bool is_about_topics = true;
  std::function<void(DomainRule&)> lower = [](DomainRule&) {};
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.element; }

class Lattice : public ::testing::TestWithParam<Row> {};

TEST_P(Lattice, EachValue_MovesUpAndDown) {
  const auto& row = GetParam();
  auto low = plain(), high = plain();
  row.lower(low.domain_rules[0]);
  row.raise(high.domain_rules[0]);

  const auto up = compare(low, high);
  ASSERT_THAT(up.changes, SizeIs(1));
  EXPECT_EQ(up.changes[0].element.element, row.element);
  EXPECT_EQ(up.changes[0].element.change, row.up);
  EXPECT_EQ(up.changes[0].element.interop, row.interop);
  EXPECT_EQ(up.changes[0].is_about_topics, row.is_about_topics);
  EXPECT_EQ(up.verdict, row.up == narrower ? stronger : row.up);
  EXPECT_EQ(up.flag_day_domains.empty(), row.interop == Interop::none);

  const auto down = compare(high, low);
  ASSERT_THAT(down.changes, SizeIs(1));
  EXPECT_EQ(down.changes[0].element.change, row.down);
  EXPECT_EQ(down.changes[0].element.old_value, up.changes[0].element.new_value);
  EXPECT_EQ(down.verdict, row.down == wider ? weaker : row.down);

  EXPECT_EQ(compare(low, low).verdict, neutral);
  EXPECT_THAT(compare(high, high).changes, IsEmpty());
}

template <class T>
std::function<void(DomainRule&)> set(T DomainRule::*member, T value) {
  return [=](DomainRule& rule) { rule.*member = value; };
}
template <class T>
std::function<void(DomainRule&)> set(T TopicRule::*member, T value) {
  return [=](DomainRule& rule) { rule.topic_rules[0].*member = value; };
}
void remove_domain(DomainRule& rule) { rule.domains.ranges = {{7, 7}}; }
void cover_all(DomainRule& rule) { rule.domains.ranges = {{0, 0}, {7, 7}}; }

INSTANTIATE_TEST_SUITE_P(
    Table, Lattice,
    ::testing::Values(
        Row{"allow_unauthenticated_participants",
            set(&DomainRule::allow_unauthenticated_participants, false), stronger, weaker,
            Interop::none, false, set(&DomainRule::allow_unauthenticated_participants, true)},
        Row{"enable_join_access_control", set(&DomainRule::enable_join_access_control, true),
            stronger, weaker, Interop::none, false,
            set(&DomainRule::enable_join_access_control, false)},
        Row{"enable_key_revision", set(&DomainRule::enable_key_revision, true), stronger, weaker,
            Interop::participant, false},
        Row{"discovery_protection_kind", set(&DomainRule::discovery_protection_kind, Kind::encrypt),
            stronger, weaker, Interop::participant, false},
        Row{"liveliness_protection_kind",
            set(&DomainRule::liveliness_protection_kind, Kind::encrypt), stronger, weaker,
            Interop::participant, false},
        Row{"rtps_protection_kind", set(&DomainRule::rtps_protection_kind, Kind::encrypt), stronger,
            weaker, Interop::participant, false},
        Row{"rtps_protection_kind",
            set(&DomainRule::rtps_protection_kind, Kind::sign_with_origin_authentication), stronger,
            weaker, Interop::participant, false},
        Row{"rtps_psk_protection_kind", set(&DomainRule::rtps_psk_protection_kind, Kind::sign),
            stronger, weaker, Interop::participant, false},
        Row{"enable_discovery_protection", set(&TopicRule::enable_discovery_protection, true),
            stronger, weaker, Interop::endpoint, true,
            set(&TopicRule::enable_discovery_protection, false)},
        Row{"enable_liveliness_protection", set(&TopicRule::enable_liveliness_protection, true),
            stronger, weaker, Interop::endpoint, true,
            set(&TopicRule::enable_liveliness_protection, false)},
        Row{"enable_read_access_control", set(&TopicRule::enable_read_access_control, true),
            stronger, weaker, Interop::endpoint, true,
            set(&TopicRule::enable_read_access_control, false)},
        Row{"enable_write_access_control", set(&TopicRule::enable_write_access_control, true),
            stronger, weaker, Interop::endpoint, true,
            set(&TopicRule::enable_write_access_control, false)},
        Row{"metadata_protection_kind", set(&TopicRule::metadata_protection_kind, Kind::encrypt)},
        Row{"data_protection_kind", set(&TopicRule::data_protection_kind, Kind::encrypt)},
        Row{"data_protection_kind", [](DomainRule&) {}, stronger, weaker, Interop::endpoint, true,
            set(&TopicRule::data_protection_kind, Kind::none)},
        // A topic or a domain that no rule covers cannot be used, so fewer of them are narrower.
        Row{"topic_rule", set(&TopicRule::topic_expression, std::string("a*")), narrower, wider},
        Row{"domain_rule", remove_domain, narrower, wider, Interop::participant, false,
            cover_all}));

TEST(Lattice, Kinds_AreOrderedByLevelAndOrigin) {
  EXPECT_EQ(compare_kinds(Kind::none, Kind::sign), stronger);
  EXPECT_EQ(compare_kinds(Kind::sign, Kind::encrypt), stronger);
  EXPECT_EQ(compare_kinds(Kind::sign, Kind::sign_with_origin_authentication), stronger);
  EXPECT_EQ(compare_kinds(Kind::encrypt, Kind::encrypt_with_origin_authentication), stronger);
  EXPECT_EQ(compare_kinds(Kind::none, Kind::encrypt_with_origin_authentication), stronger);
  EXPECT_EQ(compare_kinds(Kind::encrypt_with_origin_authentication,
                          Kind::sign_with_origin_authentication),
            weaker);
  EXPECT_EQ(compare_kinds(Kind::encrypt, Kind::sign_with_origin_authentication), mixed);
  EXPECT_EQ(compare_kinds(Kind::sign_with_origin_authentication, Kind::encrypt), mixed);
  EXPECT_EQ(compare_kinds(Kind::encrypt, Kind::encrypt), neutral);
}

}  // namespace
}  // namespace ddssec::governance
