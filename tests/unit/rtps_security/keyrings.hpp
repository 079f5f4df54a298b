// Participants that have matched, and the messages of their writer.
#pragma once

namespace ddssec::rtps::keyrings {

using namespace testing;

struct Protected : Pair {
  explicit Protected(const Rules& rules) : Pair(rules) { EXPECT_TRUE(match()); }
  Data data(std::int64_t number) const {
    static const Bytes octets(8);
    return {kEntityIdUnknown, writer.entity, {number}, {}, PayloadKind::data, octets};
  }
};

}  // namespace ddssec::rtps::keyrings
