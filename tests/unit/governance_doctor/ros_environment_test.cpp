// The environment in which a node of ROS 2 would start, and the rights that it needs.
#include "governance/doctor/ros_environment.hpp"

#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/unit/governance_doctor/libraries.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Measured with rcl of ROS 2 Humble.
TEST(NodeDomain, RosDomainId_IsReadAsRclReadsIt) {
  EXPECT_EQ(node_domain(""), 0u);
  EXPECT_EQ(node_domain("0"), 0u);
  EXPECT_EQ(node_domain("010"), 8u);
  EXPECT_EQ(node_domain("0x10"), 16u);
  EXPECT_EQ(node_domain(" 7"), 7u);
  EXPECT_EQ(node_domain("+7"), 7u);
  EXPECT_EQ(node_domain("7 rest"), 7u);
  for (const char* const bad : {"08", "x", "-1", "4294967295"})
    EXPECT_EQ(node_domain(bad), std::nullopt) << bad;
}

class RosEnvironmentTest : public libraries::HostPlugins {
 protected:
  void SetUp() override {
    HostPlugins::SetUp();
    keystore_ = root_ / "keystore";
    environment_ = {{"ROS_SECURITY_ENABLE", "true"},
                    {"ROS_SECURITY_STRATEGY", "Enforce"},
                    {"ROS_SECURITY_KEYSTORE", keystore_.string()},
                    {"RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp"},
                    {"LD_LIBRARY_PATH", (root_ / "ours").string()}};
    enclave({"rt/chatter"});
  }
  // Makes the enclave /talker, whose node may use these topics and what each node needs.
  void enclave(const std::vector<std::string>& topics, bool is_for_nodes = true) {
    auto grant = grant_for("CN=talker", topics.front());
    for (const auto& topic : topics)
      for (auto* list : {&grant.rules[0].publish, &grant.rules[0].subscribe})
        list->push_back({.topics = {{topic}}});
    if (is_for_nodes)
      for (auto* list : {&grant.rules[0].publish, &grant.rules[0].subscribe})
        list->push_back({.topics = {{"r?/*"}, {"ros_discovery_info"}}});
    folder_ = participant("keystore/enclaves/talker", strict_governance(), {.grants = {grant}});
    // The names of the files are those of ROS 2.
    auto named = pki::participant_folder(folder_.folder, pki::FolderLayout::sros2);
    const auto self = make_leaf(identity_ca_, "CN=talker");
    write(named.certificate, self.certificate.pem());
    self.key.to_pem()->expose(
        [&](BytesView octets) { write(named.key, std::string(as_text(octets))); });
    fs::permissions(named.key, fs::perms::owner_read | fs::perms::owner_write);
    fs::rename(folder_.identity_ca, named.identity_ca);
    fs::rename(folder_.permissions_ca, named.permissions_ca);
    folder_ = named;
  }
  Diagnosis said() const {
    Diagnosis out;
    diagnose_ros(load_folder(folder_, kNow), environment_, {.now = kNow}, out);
    return out;
  }
  std::string message(Rule rule) const {
    const auto all = said();
    EXPECT_THAT(rules_of(all), Contains(rule));
    return finding_of(all, rule).message;
  }
  // Sets a variable for one question.
  std::string message_with(const std::string& name, const std::string& value, Rule rule) {
    const auto former = environment_;
    environment_[name] = value;
    auto out = message(rule);
    environment_ = former;
    return out;
  }

  fs::path keystore_;
  RosEnvironment environment_;
  pki::ParticipantFolder folder_;
};

TEST_F(RosEnvironmentTest, CompleteEnvironment_HasNoFinding) {
  EXPECT_THAT(rules_of(said()), IsEmpty());
  EXPECT_TRUE(said().outcomes().all_ok());
}

TEST_F(RosEnvironmentTest, WordsThatAreSpeltOtherwise_AreQuoted) {
  EXPECT_THAT(message_with("ROS_SECURITY_ENABLE", "True", Rule::DOC060),
              HasSubstr("\"True\"; it must be exactly \"true\""));
  EXPECT_THAT(message_with("ROS_SECURITY_STRATEGY", "", Rule::DOC061), HasSubstr("is not set"));
}

TEST_F(RosEnvironmentTest, EnclaveOfTheNode_IsComparedWithTheFolder) {
  const auto with_name = [&](const std::string& name) {
    environment_["ROS_SECURITY_ENCLAVE_OVERRIDE"] = name;
    return said();
  };
  EXPECT_THAT(rules_of(with_name("/talker")), IsEmpty());
  EXPECT_THAT(finding_of(with_name("/other"), Rule::DOC062).message,
              AllOf(HasSubstr("\"/other\""), HasSubstr("\"/talker\"")));
  EXPECT_THAT(finding_of(with_name("talker"), Rule::DOC062).message, HasSubstr("begins with"));
}

TEST_F(RosEnvironmentTest, KeystoreThatDoesNotHoldTheFolder_IsNamed) {
  EXPECT_THAT(message_with("ROS_SECURITY_KEYSTORE", "", Rule::DOC062), HasSubstr("is not set"));
  EXPECT_THAT(message_with("ROS_SECURITY_KEYSTORE", root_.string(), Rule::DOC062),
              HasSubstr("is not below its enclaves/"));
}

TEST_F(RosEnvironmentTest, RelativeKeystore_IsAWarning) {
  const auto former = fs::current_path();
  fs::current_path(keystore_.parent_path());
  environment_["ROS_SECURITY_KEYSTORE"] = keystore_.filename().string();
  const auto all = said();
  fs::current_path(former);
  EXPECT_THAT(finding_of(all, Rule::DOC062).message, HasSubstr("starts in another folder"));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(RosEnvironmentTest, DomainOfNoDocument_IsSaidWithTheRightOne) {
  EXPECT_THAT(message_with("ROS_DOMAIN_ID", "7", Rule::DOC096),
              AllOf(HasSubstr("domain 7"), HasSubstr("documents are for 0")));
  environment_["ROS_DOMAIN_ID"] = "0";
  EXPECT_THAT(rules_of(said()), IsEmpty());
}

TEST_F(RosEnvironmentTest, AnotherMiddleware_DoesNotRunOnOurs) {
  EXPECT_THAT(message_with("RMW_IMPLEMENTATION", "", Rule::DOC067), HasSubstr("is not set"));
  EXPECT_THAT(message_with("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp", Rule::DOC067),
              HasSubstr("\"rmw_fastrtps_cpp\""));
}

TEST_F(RosEnvironmentTest, LibraryPathWithoutOurs_SaysWhatComesFirst) {
  const auto with_path = [&](const std::string& path) {
    return message_with("LD_LIBRARY_PATH", path, Rule::DOC068);
  };
  EXPECT_THAT(with_path(""), HasSubstr("no folder of LD_LIBRARY_PATH"));
  EXPECT_THAT(with_path((root_ / "system/private").string()), HasSubstr("is not of ddssec"));
  put_as("text", "no library");
  EXPECT_THAT(with_path((root_ / "text").string()), HasSubstr("no library of this machine"));
}

TEST_F(RosEnvironmentTest, RelativeLibraryPath_IsAWarning) {
  const auto former = fs::current_path();
  fs::current_path(root_);
  environment_["LD_LIBRARY_PATH"] = "ours";
  const auto all = said();
  fs::current_path(former);
  EXPECT_THAT(finding_of(all, Rule::DOC068).message, HasSubstr("starts in another folder"));
  EXPECT_TRUE(all.outcomes().all_ok());
}

TEST_F(RosEnvironmentTest, KeysInHardware_AreNotReadByCyclone) {
  write(folder_.folder / "key.p11", "pkcs11:object=key");
  EXPECT_THAT(message(Rule::DOC063), HasSubstr("key.p11"));
  environment_["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp";
  EXPECT_THAT(rules_of(said()), Not(Contains(Rule::DOC063)));
}

TEST_F(RosEnvironmentTest, FlatNames_AreNotReadByRos) {
  folder_ = participant("keystore/enclaves/flat");
  EXPECT_THAT(message(Rule::DOC063), HasSubstr("identity_ca.cert.pem"));
}

TEST_F(RosEnvironmentTest, RightsOfNoNode_AreListed) {
  enclave({"rt/chatter"}, false);
  EXPECT_THAT(message(Rule::PERM040), HasSubstr("does not start in domain 0"));
  const auto all = said();
  EXPECT_THAT(finding_of(all, Rule::DOC064).message, HasSubstr("ros_discovery_info"));
  EXPECT_EQ(all.outcomes().ddssec, Outcome::late);
}

TEST_F(RosEnvironmentTest, ATopicThatIsNoneOfRos_IsNamedAsRosWouldNameIt) {
  enclave({"/chatter"});
  EXPECT_THAT(message(Rule::DOC065), HasSubstr("\"rt/chatter\""));
}

TEST_F(RosEnvironmentTest, RosoutUnderAnotherName_IsNoted) {
  enclave({"rt/talker/rosout", "ros_discovery_info"}, false);
  EXPECT_THAT(message(Rule::DOC066), HasSubstr("\"rt/talker/rosout\""));
  enclave({"rt/talker/rosout", "rt/rosout"}, false);
  EXPECT_THAT(rules_of(said()), Not(Contains(Rule::DOC066)));
}

TEST_F(RosEnvironmentTest, RightsAlone_AreJudgedWithoutTheEnvironment) {
  const auto rights = [&] {
    Diagnosis out;
    diagnose_ros_rights(load_folder(folder_, kNow), {.now = kNow}, out);
    return rules_of(out);
  };
  EXPECT_THAT(rights(), IsEmpty());
  enclave({"rt/chatter"}, false);
  EXPECT_THAT(rights(), Contains(Rule::PERM040));
  enclave({"Square"}, false);  // a participant without ROS
  EXPECT_THAT(rights(), ElementsAre(Rule::PERM034));
}

TEST(RosEnvironmentVariables, OnlyThoseThatAreSet_AreReturned) {
  const auto before = ros_environment();
  ::setenv("ROS_DOMAIN_ID", "12", 1);
  ::unsetenv("ROS_SECURITY_STRATEGY");
  const auto found = ros_environment();
  EXPECT_EQ(found.at("ROS_DOMAIN_ID"), "12");
  EXPECT_FALSE(found.contains("ROS_SECURITY_STRATEGY"));
  ::unsetenv("ROS_DOMAIN_ID");
  for (const auto& [name, value] : before) ::setenv(name.c_str(), value.c_str(), 1);
}

}  // namespace
}  // namespace ddssec::governance::doctor
