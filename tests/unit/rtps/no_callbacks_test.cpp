// Calls that a listener may not make.
#include "rtps/dcps/no_callbacks.hpp"

#include "tests/unit/rtps/accesses.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::accesses {
namespace {

using namespace std::chrono_literals;
using testing::code_of;
using ::testing::ElementsAre;
using testing::taken;

TEST_P(Access, AListener_MayNotDelete) {
  Heard heard;
  heard.to_delete = &reader;
  reader.set_listener(&heard);
  write("a", 1);
  EXPECT_EQ(code_of(heard.deleting), Code::rtps_precondition_not_met);
  EXPECT_THAT(taken(reader), ElementsAre(1));
  reader.set_listener(nullptr);
}

}  // namespace
}  // namespace ddssec::rtps::accesses
