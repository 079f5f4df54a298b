#include "governance/doctor/transport.hpp"

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(TransportCheck, Tcp_IsFoundAsCycloneDdsReadsIt) {
  for (const auto* on :
       {"<TCP><Enable>true</Enable></TCP>", "<CycloneDDS><tcp>\n<Port>0</Port><ENABLE> TRUE </></>",
        "<TCP><Enable>false</Enable></TCP><TCP><Enable>${USE_IT}</Enable></TCP>"})
    EXPECT_THAT(tcp_setting(on), HasSubstr("<TCP><Enable>")) << on;
  EXPECT_EQ(tcp_setting("<General><Transport> TCP6</Transport></General>"), "<Transport>tcp6");
  EXPECT_EQ(tcp_setting("<General><Transport>tcp</></>"), "<Transport>tcp");
  for (const auto* off :
       {"", "<CycloneDDS/>", "<TCP><Enable>false</Enable></TCP>", "<TCP/>",
        "<TCP><Enable>default</Enable></TCP>", "<!-- <TCP><Enable>true</Enable></TCP> -->",
        "<TCP><Port>1</Port></TCP><Other><Enable>true</Enable></Other>",
        "<General><Transport>udp6</Transport></General>", "<", "<TCP"})
    EXPECT_EQ(tcp_setting(off), "") << off;
}

TEST(TransportCheck, Tcp_IsWarnedOf) {
  const auto said = [](const std::optional<std::string>& configuration) {
    Diagnosis out;
    diagnose_transport(configuration, out);
    return out;
  };
  EXPECT_THAT(said(std::nullopt).checks(), IsEmpty());
  EXPECT_THAT(rules_of(said("<CycloneDDS/>")), IsEmpty());
  const auto all = said("<TCP><Enable>true</Enable></TCP>");
  EXPECT_THAT(rules_of(all), ElementsAre(Rule::DOC106));
  EXPECT_EQ(all.outcomes(), Outcomes{});
  EXPECT_EQ(finding_of(all, Rule::DOC106).severity, Severity::warning);
}

}  // namespace
}  // namespace ddssec::governance::doctor
