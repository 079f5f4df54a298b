// Elements that Cyclone DDS does not know.
#include "governance/doctor/section_elements.hpp"

#include <string>

#include <gtest/gtest.h>

#include "governance/doctor/effective_security.hpp"
#include "tests/unit/governance_doctor/configurations.hpp"

namespace ddssec::governance::doctor::configurations {
namespace {

using Place = ConfigurationPlace;

std::string with(const std::string& sections) { return document(domain(sections + security())); }

TEST(EffectiveSecurity, UnknownOption_IsADoubt) {
  const auto of = [](const std::string& inside, Place place = Place::file) {
    return effective_security(place == Place::file ? document(domain(inside + security())) : inside,
                              0, place);
  };
  for (const auto* section : {"General", "Discovery", "Internal", "Unsupported", "Tracing"}) {
    const auto begin = std::string("<") + section + ">";
    const auto read = of(begin + "\n<Foo>1</Foo></" + section + ">");
    ASSERT_EQ(read.doubts.size(), 1U) << section;
    EXPECT_EQ(read.doubts.front().line, 2);
    EXPECT_TRUE(read.problems.empty());
  }
  EXPECT_EQ(of("<General><Foo>1</>", Place::variable).doubts.size(), 1U);
  EXPECT_TRUE(of("<General><ALLOWMULTICAST>true</ALLOWMULTICAST></General>").doubts.empty());
  EXPECT_TRUE(of("<Discovery><Peers><Peer address=\"::1\"/></Peers></Discovery>").doubts.empty());
}

TEST(EffectiveSecurity, UnknownDeeper_IsADoubt) {
  for (const auto* text :
       {"<Discovery><Peers><Foo><Bar/></Foo></Peers></Discovery>",
        "<Discovery><Peers><Peer Address='::1' foo='1'/></Peers></Discovery>",
        "<Discovery><Peers><Peer Address='::1'><Foo/></Peer></Peers></Discovery>",
        "<Discovery><Ports><Foo>1</Foo></Ports></Discovery>",
        "<Threads><Thread Name='recv'><Foo/></Thread></Threads>",
        "<Threads><Thread Name='recv' foo='1'/></Threads>",
        "<Threads><Thread Name='recv'><Scheduling><Foo>1</Foo></Scheduling></Thread></Threads>",
        "<General><Interfaces><Foo/></Interfaces></General>",
        "<General><Interfaces><NetworkInterface name='lo' foo='1'/></Interfaces></General>",
        "<General><MaxMessageSize foo='1'>1400B</MaxMessageSize></General>",
        "<Partitioning><NetworkPartitions><Foo/></NetworkPartitions></Partitioning>",
        "<Internal><Watermarks><Foo>1</Foo></Watermarks></Internal>",
        "<Unsupported><BurstSize><Foo>1</Foo></BurstSize></Unsupported>",
        "<Internal><SocketReceiveBufferSize foo='1MB'/></Internal>"}) {
    const auto read = effective_security(with(text), 0, Place::file);
    EXPECT_EQ(read.doubts.size(), 1U) << text;
    EXPECT_TRUE(read.problems.empty()) << text;
    EXPECT_TRUE(
        effective_security(document(domain(text, " Id='5'") + domain(security())), 0, Place::file)
            .doubts.empty())
        << text;
  }
  for (const auto* text :
       {"<General><Interfaces><NetworkInterface name='lo' "
        "priority='default'/></Interfaces></General>",
        "<Threads><Thread "
        "Name='recv'><Scheduling><Class>default</Class></Scheduling></Thread></Threads>",
        "<Internal><Watermarks><WhcHigh>1MB</WhcHigh></Watermarks></Internal>",
        "<Internal><HeartbeatInterval min='5ms'>100ms</HeartbeatInterval></Internal>",
        "<Partitioning><IgnoredPartitions><IgnoredPartition DCPSPartitionTopic='a.b'/>"
        "</IgnoredPartitions></Partitioning>"})
    EXPECT_TRUE(effective_security(with(text), 0, Place::file).doubts.empty()) << text;
}

}  // namespace
}  // namespace ddssec::governance::doctor::configurations
