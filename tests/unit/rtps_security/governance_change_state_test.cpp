// Each transition leaves a state that its readers can rely on.
#include "rtps/security/governance_change_state.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using Phase = GovernanceChangeState::Phase;
using Version = GovernanceChangeState::Version;
using Attributes = GovernanceChangeState::Attributes;

constexpr Version kFormer{.revision = 1, .digest = {1}};
constexpr Version kNext{.revision = 2, .digest = {2}};
const Attributes kOpenDomain{.rtps = ProtectionKind::none};
const Attributes kProtectedDomain{.rtps = ProtectionKind::encrypt};

GovernanceChangeState accepting(std::optional<Attributes> domain) {
  GovernanceChangeState state;
  state.note_pending(true);
  state.begin(kNext, std::move(domain));
  return state;
}

GovernanceChangeState draining(std::optional<Attributes> domain) {
  auto state = accepting(domain ? std::optional(kProtectedDomain) : std::nullopt);
  state.change(kFormer, std::move(domain));
  return state;
}

// Expects that no change is under way or pending, and that one protection counts.
void expect_none(const GovernanceChangeState& state) {
  EXPECT_EQ(state.phase(), Phase::none);
  EXPECT_FALSE(state.is_under_way());
  EXPECT_FALSE(state.is_pending());
  EXPECT_EQ(state.target(), std::nullopt);
  EXPECT_EQ(state.other_governance(), std::nullopt);
  EXPECT_EQ(state.other_domain(), std::nullopt);
}

TEST(GovernanceChangeState, NoDocument_OneProtectionCounts) {
  GovernanceChangeState state;
  expect_none(state);
  EXPECT_FALSE(state.has_changed());
  EXPECT_FALSE(state.take_changed_domain());
  EXPECT_EQ(state.take_former_domain(), std::nullopt);
}

TEST(GovernanceChangeState, DocumentWaits_IsPendingAndNotUnderWay) {
  GovernanceChangeState state;
  state.note_pending(true);
  EXPECT_TRUE(state.is_pending());
  EXPECT_FALSE(state.is_under_way());
  EXPECT_EQ(state.other_governance(), std::nullopt);
  state.note_pending(false);
  expect_none(state);
}

TEST(GovernanceChangeState, Begun_AcceptsTheNextDocument) {
  const auto state = accepting(kProtectedDomain);
  EXPECT_EQ(state.phase(), Phase::accepting);
  EXPECT_TRUE(state.is_under_way());
  EXPECT_TRUE(state.is_pending());
  EXPECT_FALSE(state.has_changed());
  EXPECT_EQ(state.target(), kNext);
  EXPECT_EQ(state.other_governance(), kNext);
  EXPECT_EQ(state.other_domain(), kProtectedDomain);
}

TEST(GovernanceChangeState, Changed_StillAcceptsTheFormerDocument) {
  auto state = draining(kOpenDomain);
  EXPECT_EQ(state.phase(), Phase::draining);
  EXPECT_TRUE(state.is_under_way());
  EXPECT_TRUE(state.is_pending());
  EXPECT_TRUE(state.has_changed());
  EXPECT_EQ(state.target(), kNext);
  EXPECT_EQ(state.other_governance(), kFormer);
  EXPECT_EQ(state.other_domain(), kOpenDomain);
  EXPECT_EQ(state.take_former_domain(), std::nullopt) << "not before the end";
}

TEST(GovernanceChangeState, Ended_GivesTheFormerDomainOnce) {
  auto state = draining(kOpenDomain);
  state.end();
  expect_none(state);
  EXPECT_TRUE(state.has_changed());
  EXPECT_EQ(state.take_former_domain(), kOpenDomain);
  EXPECT_EQ(state.take_former_domain(), std::nullopt);
}

TEST(GovernanceChangeState, ChangeOfTopicsOnly_ChangesNoDomain) {
  auto state = draining(std::nullopt);
  EXPECT_EQ(state.other_domain(), std::nullopt);
  EXPECT_FALSE(state.take_changed_domain());
  state.end();
  EXPECT_TRUE(state.has_changed());
  EXPECT_EQ(state.take_former_domain(), std::nullopt);
}

TEST(GovernanceChangeState, ChangedDomain_IsReportedOnce) {
  auto state = draining(kOpenDomain);
  EXPECT_TRUE(state.take_changed_domain());
  EXPECT_FALSE(state.take_changed_domain());
  state.end();
  EXPECT_FALSE(state.take_changed_domain());
}

TEST(GovernanceChangeState, DroppedDocument_LeavesNoTrace) {
  auto state = accepting(kProtectedDomain);
  state.end();
  expect_none(state);
  EXPECT_FALSE(state.has_changed());
  EXPECT_FALSE(state.take_changed_domain());
  EXPECT_EQ(state.take_former_domain(), std::nullopt);
}

TEST(GovernanceChangeState, SecondChange_BeginsLikeTheFirst) {
  auto state = draining(kOpenDomain);
  state.end();
  state.note_pending(true);
  state.begin({.revision = 3, .digest = {3}}, std::nullopt);
  EXPECT_EQ(state.phase(), Phase::accepting);
  EXPECT_EQ(state.target()->revision, 3u);
  EXPECT_EQ(state.take_former_domain(), kOpenDomain) << "discovery may take it late";
  state.end();
  EXPECT_EQ(state.take_former_domain(), std::nullopt);
}

// Access control of another author may have no versions.
TEST(GovernanceChangeState, FormerDocumentWithoutVersion_IsDrainedAsWell) {
  auto state = accepting(std::nullopt);
  state.change(std::nullopt, std::nullopt);
  EXPECT_EQ(state.phase(), Phase::draining);
  EXPECT_EQ(state.other_governance(), std::nullopt);
}

#ifndef NDEBUG
TEST(GovernanceChangeStateDeathTest, TransitionOutOfTurn_Aborts) {
  GovernanceChangeState none;
  EXPECT_DEATH(none.begin(kNext, std::nullopt), "is_pending_");
  EXPECT_DEATH(none.change(kFormer, std::nullopt), "accepting");
  EXPECT_DEATH(none.end(), "none");
  auto accepts = accepting(kProtectedDomain);
  EXPECT_DEATH(accepts.begin(kNext, std::nullopt), "none");
  EXPECT_DEATH(accepts.change(kFormer, std::nullopt), "other_domain_");
  auto drains = draining(std::nullopt);
  EXPECT_DEATH(drains.change(kFormer, std::nullopt), "accepting");
  EXPECT_DEATH(drains.note_pending(true), "draining");
}
#endif

}  // namespace
}  // namespace ddssec::rtps
