// The host's functions, looked up in its library or in any other of the process.
#include "plugins/cyclonedds/host_entities.hpp"

#include <unistd.h>

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

TEST(HostSymbol, ExportedByAnyLibrary_IsFound) {
  EXPECT_NE(find_host_symbol(nullptr, "getpid"), nullptr);
  EXPECT_NE(find_host_symbol(reinterpret_cast<const void*>(&::getpid), "getpid"), nullptr)
      << "in the library with that address";
}

TEST(HostSymbol, ExportedByNone_IsNull) {
  EXPECT_EQ(find_host_symbol(nullptr, "ddssec_no_library_exports_this"), nullptr);
}

TEST(HostEntities, HostWithoutTheFunctions_GivesNoAccess) {
  EXPECT_TRUE(may_have_participants(nullptr, 0)) << "the host has no such functions";
  EXPECT_EQ(find_host_entities(nullptr), nullptr) << "this program has no Cyclone DDS";
}

}  // namespace
}  // namespace ddssec::cyclonedds
