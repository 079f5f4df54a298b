// Announcements of endpoints as a peer sends them, and how the plugin counts them.
#pragma once

#include <gtest/gtest.h>

#include "plugins/cryptography/announced_endpoints.hpp"
#include "plugins/cryptography/builtin_checks.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {

inline constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}}, kSubscriptions{{0xff, 0, 4, 0xc2}};
inline constexpr std::size_t kUserData = 60'000;

inline EntityId endpoint(std::uint32_t number) {
  return {{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
           static_cast<std::uint8_t>(number), 2}};
}

/// Returns a little-endian announcement of that endpoint with so much user data.
inline Bytes announcement(std::uint32_t number, std::size_t user_data) {
  Bytes list = {0, 3, 0, 0};
  append(list, 0x2c, 2, true);
  append(list, user_data, 2, true);
  list.resize(list.size() + user_data);
  append(list, 0x5a, 2, true);
  append(list, 16, 2, true);
  append(list, kPeer.view());
  append(list, endpoint(number).view());
  append(list, 1, 4, true);
  return list;
}

/// Returns the payload that announces the end of an endpoint: its name.
inline Bytes name_only(std::uint32_t number) {
  Bytes list = {0, 3, 0, 0};
  append(list, 0x5a, 2, true);
  append(list, 16, 2, true);
  append(list, kPeer.view());
  append(list, endpoint(number).view());
  append(list, 1, 4, true);
  return list;
}

inline constexpr std::uint8_t kDisposed = 1, kUnregistered = 2, kFiltered = 4;

/// Returns a little-endian submessage with these words after the ids of reader and writer.
inline Bytes of_writer(std::uint8_t id, const EntityId& writer,
                       std::initializer_list<std::uint32_t> words) {
  Bytes out = {id, 1};
  append(out, 8 + 4 * words.size(), 2, true);
  append(out, EntityId{}.view());
  append(out, writer.view());
  for (const auto word : words) append(out, word, 4, true);
  return out;
}

struct AnnouncedEndpointsTest : ::testing::Test {
  AnnouncedEndpointsTest() { peers.peer.announced.set_account(account); }
  Code announce(std::uint32_t endpoint, std::size_t user_data = kUserData,
                const EntityId& writer = kPublications) {
    return announce_under(next_number++, endpoint, user_data, writer);
  }
  Code announce_under(std::uint32_t number, std::uint32_t endpoint,
                      std::size_t user_data = kUserData, const EntityId& writer = kPublications) {
    const DataMessage message{
        .writer = writer, .number = number, .payload = announcement(endpoint, user_data)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  Code dispose(std::uint32_t endpoint, std::uint8_t status) {
    return dispose_under(next_number++, endpoint, status);
  }
  Code dispose_under(std::uint32_t number, std::uint32_t endpoint, std::uint8_t status) {
    return dispose_as(number, status_info({status}), name_only(endpoint));
  }
  Code dispose_as(std::uint32_t number, Bytes inline_qos, Bytes payload) {
    const DataMessage message{.writer = kPublications,
                              .flags = 0x06,
                              .number = number,
                              .inline_qos = std::move(inline_qos),
                              .payload = std::move(payload)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  static Bytes status_info(std::initializer_list<std::uint8_t> values) {
    Bytes out;
    for (const auto value : values) {
      append(out, 0x71, 2, true);
      append(out, 4, 2, true);
      append(out, value, 4, false);
    }
    append(out, 1, 4, true);
    return out;
  }
  Code fragment(std::uint32_t number, const Bytes& sample, std::uint32_t first,
                std::uint16_t size) {
    const auto begin = std::size_t{first - 1} * size;
    const auto end = std::min<std::size_t>(begin + size, sample.size());
    const DataMessage message{
        .writer = kPublications,
        .number = number,
        .payload = Bytes(sample.begin() + static_cast<long>(begin),
                         sample.begin() + static_cast<long>(end)),
        .fragment = Fragment{
            .first = first, .size = size, .whole = static_cast<std::uint32_t>(sample.size())}};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  /// Passes all fragments, until one is refused.
  Code fragments(std::uint32_t number, const Bytes& sample) {
    constexpr std::uint16_t kSize = 1344;
    auto code = Code{};
    for (std::uint32_t first = 1; code == Code{} && std::size_t{first - 1} * kSize < sample.size();
         ++first)
      code = fragment(number, sample, first, kSize);
    return code;
  }
  void tell(const Bytes& submessage) {
    EXPECT_EQ(code_of(check_builtin_source(submessage, kPeer, peers)), Code{});
  }
  void acknowledge(std::uint32_t until) {
    for (const auto& writer : {kPublications, kSubscriptions})
      peers.peer.announced.acknowledged(*discovery_topic_of(writer), until);
  }
  void acknowledge() { acknowledge(next_number); }
  /// Announces endpoints until one more is refused.
  std::uint32_t fill() {
    while (announce(next) == Code{}) ++next;
    acknowledge();
    return next;
  }
  std::size_t held() const { return account->sum(); }
  std::size_t held_again() const { return account->sum(AnnouncedOctets::Heard::again); }
  static std::size_t cost(std::size_t user_data) {
    return announcement(1, user_data).size() + AnnouncedOctets::kOfEach;
  }
  static std::size_t cost_of_end() { return name_only(1).size() + AnnouncedOctets::kOfEach; }
  std::shared_ptr<AnnouncedOctets> account = std::make_shared<AnnouncedOctets>();
  OneOwner peers;
  std::uint32_t next = 1;
  std::uint32_t next_number = 1;
};

}  // namespace ddssec::cryptography::testing
