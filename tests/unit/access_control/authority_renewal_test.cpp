// Permissions CAs and governance documents that are replaced while a participant runs.
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "plugins/access_control/local_participant.hpp"
#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// The talker has files that the first CA signed. The second CA has the same name.
class PermissionsCaRenewal : public AccessControlTest {
 protected:
  void SetUp() override {
    ASSERT_TRUE(own_) << own_.error().to_sentence();
    log.all.clear();
  }

  const pki::Authority& first() const { return authorities().permissions_ca; }
  const pki::Authority& second() const { return authorities().other_ca; }

  static std::string bundle(std::initializer_list<const pki::Authority*> cas) {
    std::string out;
    for (const auto* ca : cas) out += ca->certificate().pem();
    return out;
  }
  void put(std::initializer_list<const pki::Authority*> cas) {
    folder_.replace("permissions_ca.pem", bundle(cas));
  }
  std::string permissions(const pki::Authority& ca, const char* subject = kTalker,
                          std::chrono::seconds from = -24h) const {
    auto all = rule(true);
    all.publish = {topics({"t"})};
    all.subscribe = {topics({"t"})};
    auto out = grant(subject, {all});
    out.validity.not_before = kNow + from;
    return signed_by(ca, governance::to_xml(governance::Permissions{.grants = {out}}));
  }
  std::string governance(const pki::Authority& ca) const {
    return signed_by(ca, governance::to_xml(governance_document));
  }
  void sign_all(const pki::Authority& ca) {
    folder_.replace("governance.p7s", governance(ca));
    folder_.replace("permissions.p7s", permissions(ca));
  }
  Result<spi::PermissionsHandle> from_files() {
    auto all = properties("", "");
    const auto set = [&](std::string_view name, const std::string& path) {
      for (auto& one : all)
        if (one.name == name) one.value = "file:" + path;
    };
    set(spi::property::kPermissionsCa, path_);
    set(spi::property::kGovernance, folder_.write("governance.p7s", governance(first())));
    set(spi::property::kPermissions, folder_.write("permissions.p7s", permissions(first())));
    all.push_back({std::string(spi::property::kRenewalList),
                   "file:" + folder_.path() + "/renewed.pem", false});
    return plugin->validate_local_permissions(kLocalIdentity, 0, all);
  }
  void expect_refused(Code code, const std::string& path, std::string_view why) {
    EXPECT_THAT(codes_after_looking(), ElementsAre(code));
    ASSERT_FALSE(log.all.empty());
    EXPECT_EQ(log.all.front().error.details().document, path);
    EXPECT_THAT(log.all.front().error.to_sentence(), HasSubstr(why));
    EXPECT_THAT(log.all.front().error.to_sentence(), HasSubstr("read before stay"));
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
  }
  bool accepts(const pki::Authority& ca) {
    const auto handle = remote(permissions(ca, kListener));
    return handle && plugin->check_remote_participant(*handle, 0).has_value();
  }
  bool may_publish(std::string_view topic) {
    return plugin->check_create_datawriter(*own_, 0, {.topic_name = topic}).has_value();
  }
  ProtectionKind data_of(std::string_view topic) {
    const auto found = plugin->datawriter_sec_attributes(*own_, {.topic_name = topic});
    return found && found->is_payload_protected() ? ProtectionKind::encrypt : ProtectionKind::none;
  }
  // A rule for the topic "open", whose data is not protected.
  static governance::TopicRule open_rule(std::string expression = "open") {
    return {.topic_expression = std::move(expression),
            .data_protection_kind = ProtectionKind::none};
  }
  std::vector<governance::TopicRule>& topic_rules() {
    return governance_document.domain_rules.front().topic_rules;
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.write("permissions_ca.pem", first().certificate().pem());
  Result<spi::PermissionsHandle> own_ = from_files();
};

// ---- relative paths

// The properties have relative paths, and the process has changed its working directory after it
// read them.
class RelativePermissionsPaths : public PermissionsCaRenewal {
 protected:
  void SetUp() override {
    auto all = properties("", "");
    for (auto& one : all) {
      if (one.name == spi::property::kPermissionsCa) one.value = "file:permissions_ca.pem";
      if (one.name == spi::property::kGovernance) one.value = "file:governance.p7s";
      if (one.name == spi::property::kPermissions) one.value = "file:permissions.p7s";
    }
    const test::WorkingFolder at(folder_.path());
    ASSERT_TRUE(plugin->return_permissions_handle(*own_));
    own_ = plugin->validate_local_permissions(kLocalIdentity, 0, all);
    PermissionsCaRenewal::SetUp();
  }
  void put_into(const test::TemporaryFolder& where) {
    where.replace("permissions_ca.pem", bundle({&first(), &second()}));
    topic_rules().push_back(open_rule("another"));
    where.replace("governance.p7s", governance(first()));
    where.replace("permissions.p7s", permissions(first(), kTalker, 0s));
  }
  const test::TemporaryFolder elsewhere_;
  const test::WorkingFolder there_{elsewhere_.path()};
};

TEST_F(RelativePermissionsPaths, FilesInTheNextWorkingDirectory_AreNotTaken) {
  put_into(elsewhere_);
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_FALSE(accepts(second()));
}

TEST_F(RelativePermissionsPaths, FilesWhereTheyWereAtTheStart_AreFollowed) {
  put_into(folder_);
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::permissions_ca_renewed, Code::governance_renewed,
                          Code::permissions_renewed));
  for (const auto& event : log.all)
    EXPECT_THAT(event.error.details().document, testing::StartsWith(folder_.path() + "/"));
}

// ---- overlap

TEST_F(PermissionsCaRenewal, SecondCa_IsAcceptedBesideTheFirst) {
  EXPECT_TRUE(accepts(first()));
  EXPECT_FALSE(accepts(second()));
  put({&first(), &second()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_ca_renewed));
  EXPECT_EQ(log.all.front().severity, Severity::informational);
  EXPECT_EQ(log.all.front().error.details().document, path_);
  EXPECT_TRUE(accepts(first()));
  EXPECT_TRUE(accepts(second()));
  put({&second(), &first()});
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "the order says nothing";
}

TEST_F(PermissionsCaRenewal, DocumentsOfTheSecondCa_AreTakenDuringTheOverlap) {
  put({&first(), &second()});
  codes_after_looking();
  sign_all(second());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_renewed));
  EXPECT_TRUE(may_publish("t"));
  EXPECT_EQ(plugin->renewals(*own_), 1u) << "authentication must present it";
}

// ---- the first CA leaves

TEST_F(PermissionsCaRenewal, CaThatLeaves_EndsItsPeers) {
  put({&first(), &second()});
  codes_after_looking();
  sign_all(second());
  codes_after_looking();
  const auto former = remote(permissions(first(), kListener));
  const auto moved = remote(permissions(second(), kListener));
  ASSERT_TRUE(former && moved);
  put({&second()});
  log.all.clear();
  EXPECT_THAT(poll(), IsEmpty()) << "the file may not be whole";
  EXPECT_THAT(poll(), ElementsAre(*former));
  ASSERT_EQ(log.all.size(), 2u);
  EXPECT_EQ(log.all.front().error.code(), Code::permissions_ca_renewed);
  EXPECT_EQ(log.all.back().error.code(), Code::permissions_ca_withdrawn);
  EXPECT_EQ(log.all.back().peer_subject, kListener);
  EXPECT_THAT(poll(), IsEmpty()) << "ended twice";
  EXPECT_CODE(plugin->check_remote_participant(*former, 0), permissions_ca_withdrawn);
  EXPECT_TRUE(plugin->check_remote_participant(*moved, 0));
  EXPECT_FALSE(accepts(first()));
}

TEST_F(PermissionsCaRenewal, CaThatLeaves_KeepsAPeerWhosePermissionsTheNextOneListed) {
  const auto next = permissions(second(), kListener);
  const pki::RenewalList list{.permissions = {to_bytes(as_bytes(next))}};
  folder_.replace("renewed.pem", list.text().value());
  put({&first(), &second()});
  sign_all(second());
  codes_after_looking();
  const auto former = remote(permissions(first(), kListener));
  ASSERT_TRUE(former);
  put({&second()});
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::permissions_ca_renewed, Code::peer_permissions_listed));
  EXPECT_TRUE(plugin->check_remote_participant(*former, 0));
  folder_.replace("renewed.pem", "-");
  put({&second()});
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_TRUE(plugin->check_remote_participant(*former, 0));
}

TEST_F(PermissionsCaRenewal, CaWithoutOverlap_IsTakenTogetherWithOurDocuments) {
  put({&second()});
  sign_all(second());
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::permissions_ca_renewed, Code::permissions_renewed));
  EXPECT_FALSE(accepts(first()));
  EXPECT_TRUE(accepts(second()));
  EXPECT_TRUE(may_publish("t"));
}

TEST_F(PermissionsCaRenewal, GovernanceThatComesWithAnotherCa_IsAnEvent) {
  topic_rules().insert(topic_rules().begin(), open_rule());
  sign_all(second());
  put({&second()});
  EXPECT_THAT(codes_after_looking(),
              testing::UnorderedElementsAre(Code::permissions_ca_renewed, Code::permissions_renewed,
                                            Code::governance_renewed));
}

// A host whose endpoints can get another protection.
class ChangingHost : public PermissionsCaRenewal {
 protected:
  void SetUp() override {
    make({.host_changes_protection = true});
    protect(ProtectionKind::none);
    own_ = from_files();
    PermissionsCaRenewal::SetUp();
    EXPECT_EQ(data_of("t"), ProtectionKind::none);
  }
  void protect(ProtectionKind kind) {
    for (auto& one : topic_rules()) one.metadata_protection_kind = one.data_protection_kind = kind;
  }
};

// A CA that leaves at once may have left because its key was stolen.
TEST_F(ChangingHost, CaLeavesWhileItsDocumentWaits_TheDocumentIsDropped) {
  put({&first(), &second()});
  codes_after_looking();
  governance_document.revision = 9;
  protect(ProtectionKind::encrypt);
  folder_.replace("governance.p7s", governance(second()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_changing));
  const auto waiting = *plugin->pending_governance(*own_);
  put({&first()});
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::permissions_ca_renewed, Code::governance_renewal_refused));
  EXPECT_FALSE(plugin->pending_governance(*own_));
  EXPECT_FALSE(plugin->apply_pending_governance(*own_, waiting));
  EXPECT_EQ(data_of("t"), ProtectionKind::none);
}

TEST_F(PermissionsCaRenewal, DocumentsThatComeOneLookLater_AreNoRefusal) {
  put({&second()});
  poll();
  sign_all(second());
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::permissions_ca_renewed, Code::permissions_renewed));
}

// ---- what is refused

TEST_F(PermissionsCaRenewal, FileWithoutTheCaOfOurDocuments_IsRefused) {
  put({&second()});
  expect_refused(Code::permissions_ca_renewal_refused, path_, "not one of the configured");
  EXPECT_TRUE(accepts(first()));
}

TEST_F(PermissionsCaRenewal, OlderPermissionsOfTheNewCa_AreRefusedAsARollBack) {
  put({&second()});
  folder_.replace("governance.p7s", governance(second()));
  folder_.replace("permissions.p7s", permissions(second(), kTalker, -25h));
  EXPECT_THAT(codes_after_looking(),
              testing::UnorderedElementsAre(Code::permissions_ca_renewal_refused,
                                            Code::permissions_renewal_refused,
                                            Code::governance_renewal_refused));
  EXPECT_TRUE(accepts(first()));
  EXPECT_FALSE(accepts(second()));
}

TEST_F(PermissionsCaRenewal, CaThatWasWithdrawn_IsRefusedAsARollBack) {
  put({&second()});
  sign_all(second());
  codes_after_looking();
  put({&second(), &first()});
  expect_refused(Code::permissions_ca_renewal_refused, path_, "has left the CA file");
  EXPECT_FALSE(accepts(first()));
}

TEST_F(PermissionsCaRenewal, WhatIsNoFileOfCas_IsReportedOnceAndNothingIsLost) {
  for (const auto& text :
       {std::string(), std::string("nonsense"), first().certificate().pem().substr(0, 200),
        std::string(2'000'000, 'x')}) {
    folder_.replace("permissions_ca.pem", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_ca_renewal_refused));
    EXPECT_THAT(codes_after_looking(), IsEmpty());
  }
  std::filesystem::remove(path_);
  std::filesystem::create_directory(path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_ca_renewal_refused));
  std::filesystem::remove(path_);
  put({&first()});
  EXPECT_THAT(codes_after_looking(), IsEmpty()) << "a good file between two bad ones";
  std::filesystem::remove(path_);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path_.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_ca_renewal_refused));
  ::close(socket);
  EXPECT_TRUE(accepts(first()));
  EXPECT_TRUE(may_publish("t"));
}

// The writer stops after the first of two certificates.
TEST_F(PermissionsCaRenewal, FileCutBetweenItsCertificates_LosesNoCa) {
  put({&first(), &second()});
  codes_after_looking();
  folder_.write("permissions_ca.pem", bundle({&first()}));
  poll();
  EXPECT_TRUE(accepts(second()));
  folder_.write("permissions_ca.pem", bundle({&first(), &second()}));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_TRUE(accepts(second()));
}

TEST_F(PermissionsCaRenewal, FileThatKeepsChanging_CostsOneLookForEachInterval) {
  for (int i = 0; i < 50; ++i) {
    folder_.replace("permissions_ca.pem", "nonsense " + std::to_string(i));
    clock.advance(100ms);
    plugin->poll();
  }
  EXPECT_THAT(log.all, testing::SizeIs(testing::AllOf(testing::Ge(2u), testing::Le(5u))));
}

// ---- governance

TEST_F(PermissionsCaRenewal, GovernanceThatIsOnlySignedAnew_IsNoEvent) {
  folder_.replace("governance.p7s", governance(first()));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(PermissionsCaRenewal, RuleForATopicThatNoOneUses_IsTaken) {
  EXPECT_EQ(data_of("t"), ProtectionKind::encrypt);
  topic_rules().insert(topic_rules().begin(), open_rule());
  folder_.replace("governance.p7s", governance(first()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
  EXPECT_EQ(log.all.front().severity, Severity::informational);
  EXPECT_THAT(log.all.front().error.to_sentence(), HasSubstr("\"open\""));
  EXPECT_EQ(data_of("open"), ProtectionKind::none);
  EXPECT_EQ(data_of("t"), ProtectionKind::encrypt);
}

TEST_F(PermissionsCaRenewal, RuleForATopicInUse_IsRefused) {
  EXPECT_EQ(data_of("open"), ProtectionKind::encrypt);
  topic_rules().insert(topic_rules().begin(), open_rule());
  folder_.replace("governance.p7s", governance(first()));
  expect_refused(Code::governance_renewal_refused, folder_.path() + "/governance.p7s",
                 "this participant uses the topic \"open\": restart it");
  EXPECT_EQ(data_of("open"), ProtectionKind::encrypt);
}

// The host has closed the unprotected discovery by which endpoints of the topic would be announced.
TEST_F(PermissionsCaRenewal, RuleThatOpensDiscovery_IsRefused) {
  auto open = open_rule();
  open.enable_discovery_protection = false;
  topic_rules().push_back(open);
  folder_.replace("governance.p7s", governance(first()));
  expect_refused(Code::governance_renewal_refused, folder_.path() + "/governance.p7s",
                 "participants that run hear no unprotected discovery");
}

TEST_F(PermissionsCaRenewal, RuleThatLeftTheGovernance_IsRefusedAsARollBack) {
  const auto former = governance(first());
  topic_rules().insert(topic_rules().begin(), open_rule());
  folder_.replace("governance.p7s", governance(first()));
  codes_after_looking();
  folder_.replace("governance.p7s", former);
  expect_refused(Code::governance_renewal_refused, folder_.path() + "/governance.p7s",
                 "the rule for \"open\"");
  EXPECT_EQ(data_of("open"), ProtectionKind::none);
}

TEST_F(PermissionsCaRenewal, OtherProtectionKind_IsRefusedWithBothValues) {
  governance_document.domain_rules.front().rtps_protection_kind = ProtectionKind::sign;
  folder_.replace("governance.p7s", governance(first()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewal_refused));
  ASSERT_FALSE(log.all.empty());
  const auto& details = log.all.front().error.details();
  EXPECT_EQ(details.field, "rtps_protection_kind");
  EXPECT_EQ(details.expected + " to " + details.found, "ENCRYPT to SIGN");
  EXPECT_THAT(details.hint, HasSubstr("restart all participants of the domain"));
}

TEST_F(PermissionsCaRenewal, GovernanceOfAnotherCa_IsRefused) {
  folder_.replace("governance.p7s", governance(second()));
  expect_refused(Code::governance_renewal_refused, folder_.path() + "/governance.p7s",
                 "not one of the configured");
}

TEST_F(PermissionsCaRenewal, MoreTopicsThanAreRemembered_LeaveOnlyRulesAtTheEnd) {
  for (std::size_t i = 0; i <= LocalParticipant::kMaxTopicsInUse; ++i)
    data_of("t" + std::to_string(i));
  const auto all = topic_rules();
  topic_rules().insert(topic_rules().begin(), open_rule());
  folder_.replace("governance.p7s", governance(first()));
  expect_refused(Code::governance_renewal_refused, folder_.path() + "/governance.p7s",
                 "further rules after the others");
  topic_rules() = all;
  topic_rules().push_back(open_rule());
  folder_.replace("governance.p7s", governance(first()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
}

// ---- a host that presents the permissions that it began with

class PresentedOnce : public PermissionsCaRenewal {
 protected:
  PresentedOnce() {
    make({.presents_renewed_permissions = [] { return false; }});
    own_ = from_files();
  }
};

TEST_F(PresentedOnce, RenewedPermissions_AreNotTaken) {
  folder_.replace("permissions.p7s", permissions(first(), kTalker, -1h));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_EQ(plugin->renewals(*own_), 0u);
}

TEST_F(PresentedOnce, SecondCa_IsAcceptedUntilItLeaves) {
  put({&first(), &second()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::permissions_ca_renewed));
  const auto peer = remote(permissions(second(), kListener));
  ASSERT_TRUE(peer);
  EXPECT_TRUE(plugin->check_remote_participant(*peer, 0));
  put({&first()});
  EXPECT_THAT(poll(), IsEmpty()) << "the file may not be whole";
  EXPECT_THAT(poll(), ElementsAre(*peer));
  EXPECT_FALSE(accepts(second()));
}

// With an overlap, the CA is adopted together with the permissions that are in their file at that
// time.
TEST_F(PresentedOnce, CaWithoutOverlap_IsRefused) {
  sign_all(second());
  put({&second()});
  log.all.clear();
  for (int i = 0; i < 3; ++i) poll();
  EXPECT_TRUE(std::ranges::any_of(log.all, [](const auto& event) {
    return event.error.code() == Code::permissions_ca_renewal_refused;
  }));
  EXPECT_EQ(plugin->renewals(*own_), 0u);
  EXPECT_TRUE(accepts(first()));
  EXPECT_FALSE(accepts(second()));
}

TEST_F(PresentedOnce, FurtherTopicRules_AreTaken) {
  topic_rules().push_back(open_rule());
  folder_.replace("governance.p7s", governance(first()));
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::governance_renewed));
}

TEST_F(PermissionsCaRenewal, Record_FollowsTheCasAndTheGovernance) {
  const auto cas = [&] { return test::recorded_document(documents, "permissions CA"); };
  const auto rules = [&] { return test::recorded_document(documents, "governance"); };
  EXPECT_EQ(cas()["file"], path_);
  EXPECT_EQ(cas()["in_force"].size(), 1u);
  const auto former = rules()["in_force"][0]["sha256"];

  put({&second()});
  codes_after_looking();
  EXPECT_EQ(cas()["refused"]["name"], "permissions_ca_renewal_refused");
  EXPECT_EQ(cas()["refused"]["stands"], true);
  folder_.replace("governance.p7s", "broken");
  codes_after_looking();
  EXPECT_EQ(rules()["refused"]["name"], "governance_renewal_refused");
  EXPECT_EQ(rules()["in_force"][0]["sha256"], former);

  sign_all(second());
  codes_after_looking();
  EXPECT_EQ(cas()["in_force"][0]["number"], second().certificate().serial());
  EXPECT_EQ(cas()["refused"]["stands"], false);
  EXPECT_EQ(rules()["refused"]["stands"], false);
  EXPECT_NE(rules()["in_force"][0]["sha256"], former);
}

}  // namespace
}  // namespace ddssec::access_control
