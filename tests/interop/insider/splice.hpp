// Announcements each of which is harmless. If the receiver's host joins the first fragment of one
// to the second fragment of another, it gets one that is not.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace splice {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kPublications[] = {0xff, 0, 3, 0xc2};
constexpr std::uint8_t kEncapsulation[] = {0, 3, 0, 0};
constexpr std::size_t kDull = 32, kPiece = 1024;

inline void append(Bytes& out, std::size_t value, int octets) {
  for (int shift = 0; shift < 8 * octets; shift += 8)
    out.push_back(static_cast<std::uint8_t>(value >> shift));
}

inline void append(Bytes& out, std::span<const std::uint8_t> octets) {
  for (const auto octet : octets) out.push_back(octet);
}

inline void append_parameter(Bytes& out, std::size_t id, const Bytes& value) {
  append(out, id, 2);
  append(out, value.size(), 2);
  append(out, value);
}
inline void append_endpoint(Bytes& out, Bytes prefix, std::uint8_t number, std::uint8_t kind) {
  for (const std::uint8_t octet : {std::uint8_t{0}, std::uint8_t{0}, number, kind})
    prefix.push_back(octet);
  append_parameter(out, 0x5a, prefix);
}

/// Returns a DATA_FRAG of one fragment, little endian. With `ends`, it says that the named endpoint
/// is gone.
inline Bytes fragment(std::size_t number, std::size_t index, std::size_t size, const Bytes& whole,
                      bool ends) {
  const std::uint8_t header[] = {
      0x16, static_cast<std::uint8_t>(ends ? 3 : 1), 0, 0, 0, 0, 28, 0, 0, 0, 0, 0};
  Bytes out;
  append(out, header);
  append(out, kPublications);
  append(out, 0, 4);
  append(out, number, 4);
  append(out, index, 4);
  append(out, 1, 2);
  append(out, size, 2);
  append(out, whole.size(), 4);
  constexpr std::uint8_t kEnds[] = {0x71, 0, 4, 0, 0, 0, 0, 3, 1, 0, 0, 0};
  if (ends) append(out, kEnds);
  const auto from = (index - 1) * size, to = std::min(from + size, whole.size());
  append(out, std::span(whole).subspan(from, to - from));
  const auto length = out.size() - 4;
  out[2] = static_cast<std::uint8_t>(length);
  out[3] = static_cast<std::uint8_t>(length >> 8);
  return out;
}

/// Returns a list that says nothing, in two fragments of kDull.
inline Bytes dull(const Bytes& own) {
  Bytes out;
  append(out, kEncapsulation);
  append_endpoint(out, own, 0x77, 3);
  append_parameter(out, 0, Bytes(4));
  append_parameter(out, 1, {});
  return out;
}

/// Returns a list whose second fragment is `inner`: user data of an endpoint of the sender, or
/// parameters with `opens`.
inline Bytes carrier(const Bytes& own, const Bytes& inner, bool opens) {
  Bytes out;
  append(out, kEncapsulation);
  if (!opens) append_endpoint(out, own, 0x77, 3);
  const auto to_come = kPiece - out.size() - 4 - (opens ? 0 : 4);
  append_parameter(out, 0, Bytes(to_come));
  if (opens)
    append(out, inner);
  else
    append_parameter(out, 0x2c, inner);
  append_parameter(out, 1, {});
  return out;
}

/// Returns the submessages, from that sequence number on. The host keeps parts of sixteen samples,
/// and drops the highest one for the seventeenth, so it has only the second fragment of `target`.
/// Many others follow, until no receiver may remember the first one. Then another first fragment
/// comes.
inline std::vector<Bytes> plan(std::size_t first, const Bytes& own, const Bytes& inner, bool ends) {
  constexpr std::size_t kOfHost = 16, kToForget = 36;
  const auto target = first + kOfHost;
  const auto harmless = carrier(own, inner, false), filler = dull(own);
  std::vector<Bytes> out = {fragment(target, 1, kPiece, harmless, ends)};
  const auto add_fillers = [&](std::size_t from, std::size_t count, std::size_t index) {
    for (auto number = from; number < from + count; ++number)
      out.push_back(fragment(number, index, kDull, filler, false));
  };
  add_fillers(first, kOfHost, 1);
  add_fillers(first, kOfHost, 2);
  add_fillers(target - 1, 1, 1);  // the host dropped this one, too
  add_fillers(target - 1, 1, 2);
  out.push_back(fragment(target, 2, kPiece, harmless, ends));
  for (std::size_t i = 1; i <= kToForget; ++i)
    for (const std::size_t index : {1, 2}) add_fillers(target + i, 1, index);
  out.push_back(fragment(target, 1, kPiece, carrier(own, inner, true), ends));
  return out;
}

}  // namespace splice
