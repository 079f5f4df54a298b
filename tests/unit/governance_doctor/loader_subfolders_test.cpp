// Subfolders that the dynamic loader searches first.
#include "governance/doctor/loader_subfolders.hpp"

#include <elf.h>

#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(LoaderSubfolders, OutputOfTheLoader_NamesThem) {
  EXPECT_THAT(
      subfolders_in(
          "  12:\t search path=/p/glibc-hwcaps/x86-64-v2:/p/tls:/p\t\t(LD_LIBRARY_PATH)\n", "/p"),
      ElementsAre("glibc-hwcaps/x86-64-v2", "tls"));
  EXPECT_THAT(subfolders_in("  12:\t search path=/p\t\t(LD_LIBRARY_PATH)\n", "/p"), IsEmpty());
  EXPECT_THAT(subfolders_in("  12:\t search path=/usr/lib/tls:/usr/lib\t\t(x)\n", "/p"), IsEmpty());
  EXPECT_THAT(subfolders_in("find library=libm.so.6 [0]; searching\n", "/p"), IsEmpty());
}

}  // namespace
}  // namespace ddssec::governance::doctor
