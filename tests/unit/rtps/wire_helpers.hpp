// What the wire tests share: functions that build one submessage and read it again.
#pragma once

#include <array>

#include <gtest/gtest.h>

#include "tests/support/code_of.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::rtps::testing {

inline constexpr EntityId kReader{{0, 0, 1, 0x07}};
inline constexpr EntityId kWriter{{0, 0, 2, 0x02}};

/// Returns the octets of one submessage.
template <class S>
Bytes written(const S& submessage, Endian endian = Endian::little) {
  std::array<std::uint8_t, 4096> buffer{};
  SpanWriter out(buffer, endian);
  write(out, submessage);
  EXPECT_FALSE(out.overflowed());
  return to_bytes(out.view());
}

/// Returns a whole message with these submessages.
inline Bytes message(std::initializer_list<Bytes> submessages) {
  std::array<std::uint8_t, 8192> buffer{};
  SpanWriter out(buffer);
  write(out, Header{});
  for (const auto& submessage : submessages) out.write_bytes(submessage);
  return to_bytes(out.view());
}

/// Returns the view that a MessageReader gives of one submessage. `octets` must outlive it.
inline SubmessageView view_of(const Bytes& octets) {
  return **MessageReader::over_submessages({}, octets).next();
}

using test::code_of;

}  // namespace ddssec::rtps::testing
