// Governance documents that protect topics in use in another way, and their revisions.
#include "plugins/access_control/local_participant.hpp"

#include <gmock/gmock.h>

#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr auto kSign = ProtectionKind::sign, kEncrypt = ProtectionKind::encrypt;

class GovernancePhases : public AccessControlTest {
 protected:
  explicit GovernancePhases(bool changes_protection = true)
      : changes_protection_(changes_protection) {
    topic().metadata_protection_kind = topic().data_protection_kind = kSign;
    start();
    EXPECT_EQ(data_of("t"), kSign);
  }
  /// A participant with the document as it is now.
  void start(std::uint32_t first = 1) {
    make({.host_changes_protection = changes_protection_});
    put(first);
    auto all = properties("", open_permissions(kTalker));
    for (auto& one : all)
      if (one.name == spi::property::kGovernance) one.value = "file:" + path_;
    own_ = plugin->validate_local_permissions(kLocalIdentity, 0, all);
    EXPECT_TRUE(own_) << own_.error().to_sentence();
    log.all.clear();
  }
  governance::TopicRule& topic() { return governance_document.domain_rules[0].topic_rules[0]; }
  std::string document(std::uint32_t revision) {
    governance_document.revision = revision;
    return signed_document(governance::to_xml(governance_document));
  }
  void put(const std::string& text) { folder_.replace("governance.p7s", text); }
  void put(std::uint32_t revision) { put(document(revision)); }
  /// A document in which topics whose names begin with "n" are open.
  void put_with_open_topics(std::uint32_t revision) {
    auto open = topic();
    open.topic_expression = "n*";
    open.metadata_protection_kind = open.data_protection_kind = ProtectionKind::none;
    auto& rules = governance_document.domain_rules[0].topic_rules;
    rules.insert(rules.begin(), open);
    put(revision);
  }
  void raise() { topic().metadata_protection_kind = topic().data_protection_kind = kEncrypt; }
  void expect_refused(std::string_view field, std::string_view why) {
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewal_refused));
    ASSERT_FALSE(log.all.empty());
    EXPECT_EQ(log.all.front().error.details().field, field);
    refusal_ = log.all.front().error.to_sentence();
    EXPECT_THAT(refusal_, HasSubstr(why));
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
  }
  ProtectionKind data_of(std::string_view name) {
    const auto attributes = plugin->datawriter_sec_attributes(*own_, {.topic_name = name});
    return attributes ? attributes->payload : ProtectionKind::none;
  }
  std::uint32_t revision() { return plugin->governance_version(*own_)->revision; }
  bool apply() {
    const auto pending = plugin->pending_governance(*own_);
    return pending && plugin->apply_pending_governance(*own_, *pending);
  }
  bool waits() { return plugin->pending_governance(*own_).has_value(); }

  const bool changes_protection_;
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/governance.p7s";
  Result<spi::PermissionsHandle> own_ = fail(Code::unknown_permissions_handle);
  std::string refusal_;  // the sentence of the last one
};

TEST_F(GovernancePhases, MoreProtection_WaitsUntilTheHostHasChangedItsEndpoints) {
  raise();
  const auto text = document(2);
  put(text);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing));
  EXPECT_EQ(log.all.front().error.details().document, path_);
  EXPECT_EQ(log.all.front().error.details().found, "2");
  EXPECT_EQ(data_of("t"), kSign);
  EXPECT_EQ(data_of("new"), kSign) << "endpoints that are made meanwhile are as the others";
  EXPECT_EQ(revision(), 1u);
  ASSERT_TRUE(waits());
  const auto shown = test::recorded_document(documents, "governance");
  EXPECT_EQ(shown["in_force"][0]["subject"], "revision 1");
  EXPECT_EQ(shown["waiting"]["subject"], "revision 2");
  EXPECT_EQ(shown["waiting"]["sha256"], to_hex(sha256(as_bytes(text))));
  EXPECT_EQ(plugin->pending_governance(*own_)->revision, 2u);
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "begins once";
  const auto former = *plugin->governance_version(*own_);
  const auto next = *plugin->pending_governance(*own_);
  EXPECT_EQ(plugin->endpoint_attributes_of(*own_, next, "t")->payload, kEncrypt);
  EXPECT_FALSE(plugin->endpoint_attributes_of(*own_, former, "t"));
  const auto digest = next.digest;
  EXPECT_TRUE(apply());
  EXPECT_EQ(data_of("t"), kEncrypt);
  EXPECT_EQ(plugin->endpoint_attributes_of(*own_, former, "t")->payload, kSign)
      << "for the second phase";
  EXPECT_FALSE(waits());
  EXPECT_EQ(plugin->governance_version(*own_)->digest, digest);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  EXPECT_EQ(log.all.front().error.details().found, "2");
  EXPECT_EQ(test::recorded_document(documents, "governance")["in_force"][0]["sha256"],
            to_hex(sha256(as_bytes(text))));
}

TEST_F(GovernancePhases, OldDocument_IsRefusedAsARollBack) {
  const auto old = document(1);
  raise();
  put(3);
  codes_after_looking();
  EXPECT_TRUE(apply());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  for (const auto& text : {old, document(2), document(0)}) {
    put(text);
    expect_refused("revision", "more than 3");
    EXPECT_EQ(data_of("t"), kEncrypt);
  }
}

TEST_F(GovernancePhases, OtherContentOfTheSameRevision_IsRefused) {
  raise();
  put(1);
  expect_refused("revision", "more than 1");
  EXPECT_FALSE(waits());
}

TEST_F(GovernancePhases, SameContentSignedAnew_IsNoEvent) {
  put(1);
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  put(2);
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_EQ(revision(), 2u);
}

TEST_F(GovernancePhases, DocumentWithoutARevision_CannotRaiseTheProtection) {
  put(5);  // so that the document in force is known
  codes_after_looking();
  raise();
  put(0);
  expect_refused("revision", "more than 5");
}

TEST_F(GovernancePhases, LessProtection_NamesWhatMustRestart) {
  raise();
  put(2);
  codes_after_looking();
  EXPECT_TRUE(apply());
  codes_after_looking();
  topic().data_protection_kind = kSign;
  put(3);
  expect_refused("data_protection_kind", "expected ENCRYPT, found SIGN");
  EXPECT_THAT(refusal_, HasSubstr("restart all participants of the domain"));
  EXPECT_EQ(data_of("t"), kEncrypt);
}

TEST_F(GovernancePhases, FurtherDocumentsWhileOneWaits_AreLookedAtAfterwards) {
  raise();
  put(2);
  codes_after_looking();
  for (std::uint32_t i = 3; i < 20; ++i) {
    put(i);
    EXPECT_THAT(codes_after_looking(), IsEmpty());
  }
  EXPECT_EQ(plugin->pending_governance(*own_)->revision, 2u);
  EXPECT_TRUE(apply());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  EXPECT_EQ(revision(), 19u);
}

TEST_F(GovernancePhases, AnotherVersionThanTheOneThatWaits_IsNotApplied) {
  raise();
  put(2);
  codes_after_looking();
  auto other = *plugin->pending_governance(*own_);
  other.digest[0] ^= 1;
  EXPECT_FALSE(plugin->apply_pending_governance(*own_, other));
  EXPECT_EQ(data_of("t"), kSign);
}

TEST_F(GovernancePhases, NewTopicWhileOneWaits_MustFitIt) {
  raise();
  auto& rules = governance_document.domain_rules[0].topic_rules;
  auto less = topic();
  less.topic_expression = "less";
  less.metadata_protection_kind = less.data_protection_kind = ProtectionKind::none;
  rules.insert(rules.begin(), less);
  put(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing));
  EXPECT_EQ(data_of("new"), kSign);
  const auto refused = plugin->datawriter_sec_attributes(*own_, {.topic_name = "less"});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::governance_change_under_way);
  EXPECT_THAT(refused.error().to_sentence(), HasSubstr("\"less\" was not in use when revision 2"));
  EXPECT_TRUE(apply());
  EXPECT_TRUE(plugin->datawriter_sec_attributes(*own_, {.topic_name = "less"}));
  EXPECT_EQ(data_of("less"), ProtectionKind::none);
}

TEST_F(GovernancePhases, HalfOfADocumentOrOneOfAnotherCa_ChangesNothing) {
  raise();
  const auto whole = document(2);
  for (const auto& text :
       {whole.substr(0, whole.size() / 2), std::string(),
        signed_by(authorities().other_ca, governance::to_xml(governance_document))}) {
    put(text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewal_refused));
    EXPECT_FALSE(waits());
    EXPECT_EQ(data_of("t"), kSign);
  }
}

TEST_F(GovernancePhases, EachBitOfTheRevision_IsSigned) {
  auto text = document(1);
  raise();
  text = document(2);
  const auto at = text.find("revision=\"2\"");
  ASSERT_NE(at, std::string::npos);
  text[at + 10] = '9';
  put(text);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewal_refused));
  EXPECT_FALSE(waits());
}

TEST_F(GovernancePhases, RuleBeforeTheOneInUse_ThatProtectsMore_Waits) {
  auto first = topic();
  first.topic_expression = "t";
  first.metadata_protection_kind = first.data_protection_kind = kEncrypt;
  auto& rules = governance_document.domain_rules[0].topic_rules;
  rules.insert(rules.begin(), first);
  put(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing));
}

TEST_F(GovernancePhases, RuleBeforeTheOneInUse_ThatProtectsLess_IsRefused) {
  auto first = topic();
  first.topic_expression = "t";
  first.data_protection_kind = ProtectionKind::none;
  auto& rules = governance_document.domain_rules[0].topic_rules;
  rules.insert(rules.begin(), first);
  put(2);
  expect_refused("data_protection_kind", "\"t\": restart it");
}

TEST_F(GovernancePhases, TopicThatOnlyPeersNamed_IsNotInUse) {
  for (std::size_t i = 0; i <= LocalParticipant::kMaxTopicsInUse; ++i)
    EXPECT_EQ(plugin->unused_topic_attributes(*own_, "n" + std::to_string(i))->payload, kSign);
  put_with_open_topics(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  EXPECT_EQ(plugin->unused_topic_attributes(*own_, "n1")->payload, ProtectionKind::none);
}

// The keeper of a domain has endpoints on topics that peers name, one after the other.
TEST_F(GovernancePhases, TopicsThatTheHostForgot_AreNotInUse) {
  for (std::size_t i = 0; i <= LocalParticipant::kMaxTopicsInUse; ++i) {
    const auto name = "n" + std::to_string(i);
    EXPECT_EQ(data_of(name), kSign);
    plugin->forget_topic(*own_, name);
  }
  put_with_open_topics(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  auto& last = governance_document.domain_rules[0].topic_rules.back();
  last.metadata_protection_kind = last.data_protection_kind = kEncrypt;
  put(3);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing)) << "t is in use";
}

// It is not known which others are in use, so none of them counts as forgotten.
TEST_F(GovernancePhases, TooManyTopicsAtOnce_StayInUse) {
  const auto name = [](std::size_t i) { return "n" + std::to_string(i); };
  for (std::size_t i = 0; i <= LocalParticipant::kMaxTopicsInUse; ++i) data_of(name(i));
  for (std::size_t i = 0; i <= LocalParticipant::kMaxTopicsInUse; ++i)
    plugin->forget_topic(*own_, name(i));
  raise();
  put(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewal_refused));
}

using Kind = ProtectionKind governance::DomainRule::*;
constexpr std::array<std::pair<std::string_view, Kind>, 3> kDomainKinds = {
    {{"discovery_protection_kind", &governance::DomainRule::discovery_protection_kind},
     {"liveliness_protection_kind", &governance::DomainRule::liveliness_protection_kind},
     {"rtps_protection_kind", &governance::DomainRule::rtps_protection_kind}}};
constexpr auto kNone = ProtectionKind::none;

// As `governance diff` predicts: tests/cli/governance_diff_test.py.
TEST_F(GovernancePhases, StrongerKindOfTheDomain_Waits) {
  for (const auto& [element, kind] : kDomainKinds) {
    auto& rule = governance_document.domain_rules[0];
    rule.*kind = kNone;
    start();
    std::uint32_t next = 1;
    for (const auto value : {kSign, kEncrypt}) {
      const auto before = *plugin->participant_sec_attributes(*own_);
      const auto former = *plugin->governance_version(*own_);
      rule.*kind = value;
      put(++next);
      EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing)) << element;
      EXPECT_EQ(*plugin->participant_sec_attributes(*own_), before);
      ASSERT_TRUE(waits());
      const auto other =
          plugin->participant_attributes_of(*own_, *plugin->pending_governance(*own_));
      ASSERT_TRUE(other);
      EXPECT_NE(*other, before);
      EXPECT_FALSE(plugin->participant_attributes_of(*own_, former));
      EXPECT_TRUE(apply());
      EXPECT_EQ(*plugin->participant_sec_attributes(*own_), *other);
      EXPECT_EQ(*plugin->participant_attributes_of(*own_, former), before)
          << "for the second phase";
      EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
    }
  }
}

TEST_F(GovernancePhases, WeakerKindOfTheDomain_IsRefused) {
  for (const auto& [element, kind] : kDomainKinds) {
    auto& rule = governance_document.domain_rules[0];
    rule.*kind = kEncrypt;
    start();
    std::uint32_t next = 1;
    for (const auto value : {kSign, kNone}) {
      rule.*kind = value;
      put(++next);
      expect_refused(element, to_string(value));
      EXPECT_THAT(refusal_, HasSubstr("restart all participants of the domain"));
      EXPECT_FALSE(waits());
    }
  }
}

TEST_F(GovernancePhases, StrongerKindOfTheDomainWithoutARevision_IsRefused) {
  governance_document.domain_rules[0].rtps_protection_kind = kNone;
  start(0);
  governance_document.domain_rules[0].rtps_protection_kind = kSign;
  put(0);
  expect_refused("revision", "rtps_protection_kind");
}

TEST_F(GovernancePhases, FlagsOfATopicInUse_MayOnlyBegin) {
  for (const auto& [element, flag] :
       {std::pair("enable_discovery_protection",
                  &governance::TopicRule::enable_discovery_protection),
        std::pair("enable_liveliness_protection",
                  &governance::TopicRule::enable_liveliness_protection),
        std::pair("enable_read_access_control", &governance::TopicRule::enable_read_access_control),
        std::pair("enable_write_access_control",
                  &governance::TopicRule::enable_write_access_control)}) {
    topic().*flag = false;
    start();
    ASSERT_EQ(data_of("t"), kSign);  // in use from here on
    topic().*flag = true;
    put(2);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing)) << element;
    EXPECT_TRUE(apply());
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
    topic().*flag = false;
    put(3);
    expect_refused(element, "false");
    topic().*flag = true;
  }
}

TEST_F(GovernancePhases, AttributesOfBuiltinTopics_AreThoseOfTheOtherDocumentToo) {
  governance_document.domain_rules[0].discovery_protection_kind = kSign;
  start();
  governance_document.domain_rules[0].discovery_protection_kind = kEncrypt;
  put(2);
  codes_after_looking();
  ASSERT_TRUE(waits());
  const auto now =
      plugin->datawriter_sec_attributes(*own_, {.topic_name = "DCPSPublicationsSecure"});
  const auto other = plugin->endpoint_attributes_of(*own_, *plugin->pending_governance(*own_),
                                                    "DCPSPublicationsSecure");
  ASSERT_TRUE(now && other);
  EXPECT_EQ(now->submessage, kSign);
  EXPECT_EQ(other->submessage, kEncrypt);
  EXPECT_TRUE(other->is_builtin);
}

// Endpoints that are made in the second phase still get the former protection as their second one.
TEST_F(GovernancePhases, AFurtherDocumentInTheSecondPhase_LeavesTheFormerOneKnown) {
  const auto former = *plugin->governance_version(*own_);
  topic().metadata_protection_kind = kEncrypt;
  put(2);
  codes_after_looking();
  EXPECT_TRUE(apply());
  codes_after_looking();
  topic().data_protection_kind = kEncrypt;
  put(3);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing));
  ASSERT_TRUE(waits());
  EXPECT_EQ(plugin->endpoint_attributes_of(*own_, former, "t")->submessage, kSign);
}

// Endpoints keep the protection that they were made with, as those of Cyclone DDS do.
class GovernanceOfAFixedHost : public GovernancePhases {
 protected:
  GovernanceOfAFixedHost() : GovernancePhases(false) {}
};

TEST_F(GovernanceOfAFixedHost, MoreProtectionOfATopicInUse_IsRefusedAndNamesWhatMustRestart) {
  raise();
  put(2);
  expect_refused("topic_rule", "restart the participant");
  EXPECT_FALSE(waits());
  EXPECT_EQ(data_of("t"), kSign);
}

TEST_F(GovernanceOfAFixedHost, StrongerKindOfTheDomain_IsRefusedAndNamesWhatMustRestart) {
  for (const auto& [element, kind] : kDomainKinds) {
    auto& rule = governance_document.domain_rules[0];
    rule.*kind = kSign;
    start();
    rule.*kind = kEncrypt;
    put(2);
    expect_refused(element, "restart the participant");
  }
}

TEST_F(GovernanceOfAFixedHost, MoreProtectionOfATopicThatItDoesNotUse_IsTaken) {
  auto& rules = governance_document.domain_rules[0].topic_rules;
  auto other = topic();
  other.topic_expression = "other";
  rules.insert(rules.begin(), other);
  put(2);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  rules[0].metadata_protection_kind = rules[0].data_protection_kind = kEncrypt;
  put(3);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  EXPECT_THAT(log.all.front().error.to_sentence(), HasSubstr("with more protection"));
  EXPECT_EQ(data_of("other"), kEncrypt);
  EXPECT_EQ(data_of("t"), kSign);
}

}  // namespace
}  // namespace ddssec::access_control
