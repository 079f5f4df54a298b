#include "rtps/observer/frames.hpp"

#include <algorithm>
#include <arpa/inet.h>

namespace ddssec::rtps {
namespace {

enum Link : int {
  null = 0,
  ethernet = 1,
  raw = 101,
  loop = 108,
  linux_sll = 113,
  linux_sll2 = 276
};
constexpr std::uint16_t kIpv4 = 0x0800, kIpv6 = 0x86dd, kVlan = 0x8100, kServiceVlan = 0x88a8;
constexpr std::uint8_t kUdp = 17;
constexpr std::size_t kMaxPacket = 65535;
constexpr std::size_t kMaxFragments = 64;

std::uint16_t number_at(BytesView octets, std::size_t at) {
  return static_cast<std::uint16_t>(octets[at] << 8 | octets[at + 1]);
}

// Returns the octets after the first `size` ones; empty if there are fewer.
BytesView behind(BytesView octets, std::size_t size) {
  return octets.size() < size ? BytesView() : octets.subspan(size);
}

BytesView packet_of_ethernet(BytesView frame) {
  std::size_t at = 12;
  while (frame.size() >= at + 6 &&
         (number_at(frame, at) == kVlan || number_at(frame, at) == kServiceVlan))
    at += 4;
  const bool is_ip =
      frame.size() >= at + 2 && (number_at(frame, at) == kIpv4 || number_at(frame, at) == kIpv6);
  return is_ip ? behind(frame, at + 2) : BytesView();
}

BytesView packet_of(int link, BytesView frame) {
  switch (link) {
    case null:
    case loop:
      return behind(frame, 4);
    case ethernet:
      return packet_of_ethernet(frame);
    case linux_sll:
      return behind(frame, 16);
    case linux_sll2:
      return behind(frame, 20);
    default:
      return frame;
  }
}

std::string address(int family, const std::uint8_t* octets) {
  char text[INET6_ADDRSTRLEN];
  return inet_ntop(family, octets, text, sizeof text) != nullptr ? text : "";
}

std::optional<Frames::Datagram> datagram_of(std::string from, BytesView udp) {
  constexpr std::size_t kHeader = 8;
  if (udp.size() < kHeader) return std::nullopt;
  const auto size = std::clamp<std::size_t>(number_at(udp, 4), kHeader, udp.size());
  return Frames::Datagram{std::move(from), number_at(udp, 2),
                          to_bytes(udp.subspan(kHeader, size - kHeader))};
}

// Reads packets without extension headers, and so without fragments.
std::optional<Frames::Datagram> read_ipv6(BytesView packet) {
  constexpr std::size_t kHeader = 40;
  if (packet.size() < kHeader || packet[6] != kUdp) return std::nullopt;
  return datagram_of(address(AF_INET6, packet.data() + 8), packet.subspan(kHeader));
}

}  // namespace

bool Frames::knows(int link) {
  return link == null || link == ethernet || link == raw || link == loop || link == linux_sll ||
         link == linux_sll2;
}

std::optional<Frames::Datagram> Frames::read(int link, BytesView frame) {
  const auto packet = packet_of(link, frame);
  if (packet.empty()) return std::nullopt;
  if (packet[0] >> 4 == 4) return read_ipv4(packet);
  return packet[0] >> 4 == 6 ? read_ipv6(packet) : std::nullopt;
}

std::optional<Frames::Datagram> Frames::read_ipv4(BytesView packet) {
  constexpr std::size_t kMin = 20;
  if (packet.size() < kMin || packet[9] != kUdp) return std::nullopt;
  const std::size_t header = (packet[0] & 0xfu) * 4;
  const std::size_t total = std::min<std::size_t>(number_at(packet, 2), packet.size());
  if (header < kMin || total < header) return std::nullopt;
  const auto body = packet.subspan(header, total - header);
  auto from = address(AF_INET, packet.data() + 12);
  const auto flags = number_at(packet, 6);
  const bool has_more = (flags & 0x2000) != 0;
  const std::size_t offset = (flags & 0x1fffu) * 8;
  if (!has_more && offset == 0) return datagram_of(std::move(from), body);
  Bytes key = to_bytes(packet.subspan(12, 8));
  key.insert(key.end(), {packet[9], packet[4], packet[5]});
  const auto whole = reassemble(key, {offset, to_bytes(body)}, !has_more);
  return whole ? datagram_of(std::move(from), *whole) : std::nullopt;
}

// A datagram with overlapping fragments is never reassembled.
std::optional<Bytes> Frames::reassemble(BytesView key, Fragment fragment, bool is_last) {
  if (fragment.offset + fragment.octets.size() > kMaxPacket) return std::nullopt;
  auto at = std::ranges::find_if(
      partial_, [&](const auto& known) { return std::ranges::equal(known.key, key); });
  if (at == partial_.end()) {
    if (partial_.size() >= kMaxPartial) partial_.pop_front();
    partial_.push_back({to_bytes(key), {}, {}});
    at = std::prev(partial_.end());
  }
  if (is_last) at->size = fragment.offset + fragment.octets.size();
  const bool is_new =
      std::ranges::find(at->fragments, fragment.offset, &Fragment::offset) == at->fragments.end();
  if (is_new && at->fragments.size() < kMaxFragments) at->fragments.push_back(std::move(fragment));
  std::ranges::sort(at->fragments, {}, &Fragment::offset);
  Bytes whole;
  for (const auto& part : at->fragments) {
    if (part.offset != whole.size()) return std::nullopt;
    whole.insert(whole.end(), part.octets.begin(), part.octets.end());
  }
  if (at->size != whole.size()) return std::nullopt;
  partial_.erase(at);
  return whole;
}

}  // namespace ddssec::rtps
