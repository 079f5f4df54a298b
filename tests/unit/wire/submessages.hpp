// Submessages that are written and read again, and cut anywhere.
#pragma once

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps::submessages {

using ::testing::AnyOf;
using testing::code_of;
using testing::view_of;
using testing::written;

inline SequenceNumberSet set_of(std::initializer_list<std::int64_t> numbers) {
  SequenceNumberSet set(SequenceNumber{*numbers.begin()});
  for (auto number : numbers) EXPECT_TRUE(set.insert({number}));
  return set;
}

/// Expects that the submessage is read as it was written in both byte orders, and that every
/// truncation of the body is refused.
template <class S, class Read>
void expect_round_trip(const S& submessage, Read read) {
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(submessage, endian);
    const auto view = view_of(octets);
    const auto copy = read(view);
    ASSERT_TRUE(copy) << copy.error().to_sentence();
    EXPECT_EQ(*copy, submessage);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_THAT(code_of(read(cut)), AnyOf(Code::truncated, Code::length_out_of_range)) << size;
    }
  }
}

}  // namespace ddssec::rtps::submessages
