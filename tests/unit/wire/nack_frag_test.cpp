// NACK_FRAG and its set of missing fragments.
#include "wire/nack_frag.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::kReader;
using testing::kWriter;

TEST(NackFrag, NackFrag_RoundTrips) {
  FragmentNumberSet missing(FragmentNumber{2});
  missing.insert({40});
  expect_round_trip(NackFrag{kReader, kWriter, {3}, missing, 5}, read_nack_frag);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
