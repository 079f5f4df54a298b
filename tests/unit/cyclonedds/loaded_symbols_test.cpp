// Functions that the libraries of a process export, found by the end of their names.
#include "plugins/cyclonedds/loaded_symbols.hpp"

#include <dlfcn.h>

#include "tests/support/expect_code.hpp"
#include "tests/unit/cyclonedds/psmx_library.hpp"

namespace ddssec::cyclonedds::psmx_library {
namespace {

using testing::HasSubstr;

TEST(LoadedSymbol, LibraryThatDefinesIt_IsFound) {
  EXPECT_EQ(find_loaded_symbol("_create_psmx"), std::nullopt);
  const PsmxLibrary library;
  const auto found = find_loaded_symbol("_create_psmx");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "example_create_psmx");
  EXPECT_EQ(found->library, DDSSEC_PSMX_LIKE);
  EXPECT_EQ(find_loaded_symbol("example_create_psmx"), std::nullopt) << "no type before it";
}

TEST(LoadedSymbol, OwnFunctionOfALibrary_IsFoundWhereItIsDefined) {
  // This program uses the function, and no longer name ends in the same way.
  const auto found = find_loaded_symbol("lose");
  ASSERT_TRUE(found);
  EXPECT_THAT(found->name, testing::EndsWith("lose"));
  EXPECT_THAT(found->library, HasSubstr(".so"));
  EXPECT_EQ(find_loaded_symbol("no_such_function_anywhere"), std::nullopt);
}

}  // namespace
}  // namespace ddssec::cyclonedds::psmx_library
