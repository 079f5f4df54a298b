#include "governance/doctor/cyclonedds_shared_memory.hpp"

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kOn = "<SharedMemory><Enable>true</Enable></SharedMemory>";

TEST(SharedMemorySetting, EachSpelling_IsFoundAsCycloneDdsReadsIt) {
  for (const auto* on :
       {kOn, "<CycloneDDS><Domain Id='any'><SharedMemory><Enable> true </></></></>",
        "<sharedmemory>\n<LogLevel>info</LogLevel><ENABLE>TRUE</ENABLE></sharedmemory>",
        "<SharedMemory><Enable>true", "<SharedMemory><Enable>${USE_IT}</Enable></SharedMemory>",
        "<SharedMemory><Enable>false</Enable></SharedMemory><SharedMemory><Enable>true</Enable></"
        ">"})
    EXPECT_THAT(shared_memory_setting(on), HasSubstr("<SharedMemory><Enable>")) << on;
  EXPECT_EQ(shared_memory_setting("<General><Interfaces><PubSubMessageExchange type='iox'/>"),
            "<PubSubMessageExchange>");
  for (const auto* off :
       {"", "<CycloneDDS/>", "<SharedMemory><Enable>false</Enable></SharedMemory>",
        "<SharedMemory/>", "<!-- <SharedMemory><Enable>true</Enable></SharedMemory> -->",
        "<SharedMemory><LogLevel>info</LogLevel></SharedMemory><Other><Enable>true</Enable></"
        "Other>",
        "<SharedMemoryX><Enable>true</Enable></SharedMemoryX>", "<", "<!--", "<SharedMemory"})
    EXPECT_EQ(shared_memory_setting(off), "") << off;
}

using SharedMemoryCheck = Folders;

TEST_F(SharedMemoryCheck, TheConfiguration_IsTextOrFiles) {
  EXPECT_EQ(cyclonedds_configuration(kOn), kOn);
  EXPECT_EQ(cyclonedds_configuration(" , "), "");
  fs::create_directories(root_);
  std::ofstream(root_ / "one.xml") << "<One/>";
  const auto one = (root_ / "one.xml").string();
  EXPECT_EQ(cyclonedds_configuration("file://" + one), "<One/>\n");
  EXPECT_EQ(cyclonedds_configuration(one + ",file://" + one + ',' + kOn),
            std::string("<One/>\n<One/>\n") + kOn);
  EXPECT_EQ(cyclonedds_configuration("file://" + one + ".not-there"), std::nullopt);
  // Cyclone DDS takes this for the name of a file.
  EXPECT_EQ(cyclonedds_configuration("file:" + one), std::nullopt);
}

TEST_F(SharedMemoryCheck, ProtectedSamples_MustNotPassThePluginsBy) {
  const auto loaded = load_folder(participant("talker"), kNow);
  const auto said = [](const LoadedFolder& folder,
                       const std::optional<std::string>& configuration) {
    Diagnosis out;
    diagnose_shared_memory(folder, configuration, {.now = kNow}, out);
    return out;
  };
  EXPECT_THAT(said(loaded, std::nullopt).checks(), IsEmpty());
  EXPECT_THAT(rules_of(said(loaded, "<CycloneDDS/>")), IsEmpty());
  const auto all = said(loaded, kOn);
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC100));
  EXPECT_EQ(all.outcomes(), (Outcomes{.cyclonedds = Outcome::unsafe, .ddssec = Outcome::late}));
  EXPECT_THAT(finding_of(all, Rule::DOC100).message,
              HasSubstr("<SharedMemory><Enable>true is set in CYCLONEDDS_URI"));

  auto open = strict_governance();
  auto& domain = open.domain_rules.front();
  auto& topic = domain.topic_rules.front();
  domain.rtps_protection_kind = topic.metadata_protection_kind = topic.data_protection_kind =
      ProtectionKind::none;
  topic.enable_read_access_control = topic.enable_write_access_control = false;
  const auto governed = [&] {
    const Permissions permissions{.grants = {grant_for("CN=talker")}};
    return load_folder(participant("talker", open, permissions), kNow);
  };
  EXPECT_THAT(rules_of(said(governed(), kOn)), IsEmpty());
  topic.enable_write_access_control = true;
  EXPECT_THAT(rules_of(said(governed(), kOn)), ElementsAre(Rule::DOC100));
}

}  // namespace
}  // namespace ddssec::governance::doctor
