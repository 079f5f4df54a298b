// Encapsulations that are not read.
#include "rtps/cdr/encapsulation.hpp"

#include "rtps/cdr/cdr_reader.hpp"
#include "tests/support/code_of.hpp"
#include "tests/unit/rtps/cdr_types.hpp"

namespace ddssec::rtps {
namespace {

using test::code_of;

TEST(Cdr, OtherEncapsulations_AreRefused) {
  for (std::uint8_t id : {0x04, 0x05, 0x0c, 0x20, 0xff})
    EXPECT_EQ(code_of(open_payload(Bytes{0, id, 0, 0})), Code::rtps_encapsulation_unsupported);
  for (std::uint8_t id : {0x02, 0x03, 0x08, 0x0a})
    EXPECT_EQ(code_of(deserialize<Shape>(Bytes{0, id, 0, 0})),
              Code::rtps_encapsulation_unsupported);
  EXPECT_EQ(code_of(open_payload(Bytes{0, 1, 0, 3, 1, 2})), Code::truncated);
  EXPECT_EQ(code_of(open_payload(Bytes{0, 1, 0})), Code::truncated);
}

}  // namespace
}  // namespace ddssec::rtps
