// Libraries that a library needs.
#include "governance/doctor/needed_libraries.hpp"

#include <elf.h>
#include <fstream>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"
#include "tests/unit/governance_doctor/libraries.hpp"

namespace ddssec::governance::doctor::libraries {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

TEST_F(HostPlugins, OurPluginsThatCannotBeLoaded_AreTold) {
  const auto octets = elf_that_needs("libnowhere.so.23");
  put_file("ours", "ac", octets);
  path({"ours"});
  EXPECT_THAT(message(), HasSubstr("libnowhere.so.23 is not on this machine"));
  EXPECT_EQ(said().outcomes(), (Outcomes{.ddssec = Outcome::fail}));
  fs::create_directories(root_ / "ours/beside");
  std::ofstream(root_ / "ours/beside/libnowhere.so.23") << octets_of(library_header());
  EXPECT_THAT(rules_of(said()), IsEmpty());
  fs::rename(root_ / "ours/beside/libnowhere.so.23", root_ / "system/libnowhere.so.23");
  EXPECT_THAT(rules_of(said()), IsEmpty());
  for (std::size_t size = 0; size < octets.size(); ++size)  // nothing beyond the end is read
    EXPECT_LE(needed_libraries(octets.substr(0, size)).names.size(), 1u);
}

}  // namespace
}  // namespace ddssec::governance::doctor::libraries
