// Datagrams in the frames that interfaces and capture files contain.
#include "rtps/observer/frames.hpp"

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

const Bytes kPayload = {'R', 'T', 'P', 'S', 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
constexpr int kNull = 0, kEthernet = 1, kRaw = 101, kLoop = 108, kSll = 113, kSll2 = 276;

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Bytes number(std::size_t value) {
  return {static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
}

Bytes udp(std::uint16_t port = 7400) {
  return number(5000) + number(port) + number(8 + kPayload.size()) + number(0) + kPayload;
}

// Returns an IPv4 packet. `offset` is in octets.
Bytes ipv4(const Bytes& body, std::size_t offset = 0, bool more = false, std::size_t id = 7) {
  return Bytes{0x45, 0} + number(20 + body.size()) + number(id) +
         number((more ? 0x2000 : 0) | offset / 8) + Bytes{64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2} +
         body;
}

Bytes ipv6(const Bytes& body) {
  Bytes out = Bytes{0x60, 0, 0, 0} + number(body.size()) + Bytes{17, 64};
  out.resize(24);
  out[8] = 0xfe;
  out[9] = 0x80;
  out[23] = 1;
  out.resize(40);
  return out + body;
}

void expect_heard(int link, const Bytes& frame, const std::string& from = "10.0.0.1") {
  const auto heard = Frames().read(link, frame);
  ASSERT_TRUE(heard) << "link type " << link;
  EXPECT_TRUE(Frames::knows(link));
  EXPECT_EQ(heard->from, from);
  EXPECT_EQ(heard->port, 7400);
  EXPECT_EQ(heard->payload, kPayload);
}

TEST(Frames, EveryKindOfInterface_IsHeard) {
  const Bytes addresses(12, 0xee);
  expect_heard(kEthernet, addresses + number(0x0800) + ipv4(udp()));
  expect_heard(kEthernet, addresses + number(0x8100) + number(5) + number(0x0800) + ipv4(udp()));
  expect_heard(kEthernet,
               addresses + number(0x88a8) + number(5) + number(0x8100) + number(6) +
                   number(0x86dd) + ipv6(udp()),
               "fe80::1");
  expect_heard(kRaw, ipv4(udp()));
  expect_heard(kNull, Bytes{2, 0, 0, 0} + ipv4(udp()));
  expect_heard(kLoop, Bytes{0, 0, 0, 2} + ipv4(udp()));
  expect_heard(kSll, Bytes(14, 0) + number(0x0800) + ipv4(udp()));
  expect_heard(kSll2, number(0x0800) + Bytes(18, 0) + ipv4(udp()));
  EXPECT_FALSE(Frames::knows(105));
}

TEST(Frames, WhatIsNotUdp_IsNothing) {
  EXPECT_FALSE(Frames().read(kEthernet, Bytes(12, 0xee) + number(0x0806) + ipv4(udp())));
  auto tcp = ipv4(udp());
  tcp[9] = 6;
  EXPECT_FALSE(Frames().read(kRaw, tcp));
}

TEST(Frames, FragmentsInAnyOrderAndTwice_GiveOneMessage) {
  const auto whole = udp();
  const auto part = [&](std::size_t begin, std::size_t end) {
    const auto octets = BytesView(whole).subspan(begin, end - begin);
    return ipv4(to_bytes(octets), begin, end < whole.size());
  };
  Frames frames;
  EXPECT_FALSE(frames.read(kRaw, part(16, 24)));
  EXPECT_FALSE(frames.read(kRaw, part(8, 16)));
  EXPECT_FALSE(frames.read(kRaw, part(8, 16)));
  const auto heard = frames.read(kRaw, part(0, 8));
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->payload, kPayload);
  EXPECT_FALSE(frames.read(kRaw, part(0, 8))) << "the rest is used up";
}

TEST(Frames, TooManyUnfinished_TheOldestIsForgotten) {
  const auto whole = udp();
  const auto first = to_bytes(BytesView(whole).first(16)),
             second = to_bytes(BytesView(whole).subspan(16));
  Frames frames;
  for (std::size_t id = 0; id <= Frames::kMaxPartial; ++id)
    EXPECT_FALSE(frames.read(kRaw, ipv4(first, 0, true, id)));
  EXPECT_FALSE(frames.read(kRaw, ipv4(second, 16, false, 0)));
  EXPECT_TRUE(frames.read(kRaw, ipv4(second, 16, false, 5)));
}

TEST(Frames, FramesCutAnywhereOrWithLyingLengths_GiveNothingMore) {
  const auto frame = Bytes(12, 0xee) + number(0x0800) + ipv4(udp());
  for (std::size_t size = 0; size < frame.size(); ++size) {
    const auto heard = Frames().read(kEthernet, BytesView(frame).first(size));
    EXPECT_EQ(heard.has_value(), size >= 14 + 20 + 8) << size;
  }
  for (std::size_t at = 0; at < frame.size(); ++at)
    for (const int value : {0, 0x0f, 0xff}) {
      auto changed = frame;
      changed[at] = static_cast<std::uint8_t>(value);
      const auto heard = Frames().read(kEthernet, changed);
      EXPECT_LE(heard ? heard->payload.size() : 0, kPayload.size());
    }
}

}  // namespace
}  // namespace ddssec::rtps
