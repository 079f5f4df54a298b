// A plugin that passes key token messages on to its host.
#pragma once

#include <gtest/gtest.h>

#include "base/writer.hpp"
#include "plugins/cryptography/token_ledger.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/token_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::trusting_host {

using namespace testing;

inline constexpr EntityId kWriter{{0, 0, 1, 2}}, kReader{{0, 0, 1, 7}};

struct Receiver {
  explicit Receiver(bool host_checks)
      : two(ProtectionKind::none, {}, {.host_checks_sources = host_checks}) {
    authenticate(5);
    user = two.endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none));
  }
  void authenticate(std::uint8_t seed, bool reader_speaks = true) {
    auto secret = shared_secret(seed);
    secret.own_prefix = own;
    for (auto* side : {&two.a, &two.b}) {
      // A hostile sender does not check which participant its key tokens are for.
      if (side == &two.b) secret.peer_prefix = kPeer;
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    }
    ends = reader_speaks ? two.volatile_endpoints() : two.silent_volatile_endpoints();
  }
  /// Returns what the host gets from a message with these tokens.
  Bytes decoded(std::uint32_t number, std::span<const spi::Token> tokens) {
    const auto payload = token_message({kPeer, kWriter}, {kOurs, kReader}, tokens);
    const auto octets = DataMessage{.number = number, .payload = payload}.octets();
    auto out = decode_submessage(two, ends, encode_submessage(two, ends, octets).value());
    EXPECT_TRUE(out);
    EXPECT_EQ(out->size(), octets.size());
    return std::move(*out);
  }
  /// True if the host knows the class of the message.
  bool passes(std::uint32_t number, std::span<const spi::Token> tokens) {
    return decoded(number, tokens)[24 + 104] == 'd';
  }
  /// Returns the tokens that the host finds in a message.
  static std::vector<spi::Token> tokens_in(const Bytes& submessage) {
    return read_token_message(read_data_piece(submessage).value()).value()->tokens;
  }
  std::optional<GuidPrefix> own = {};
  TwoSides two;
  WriterToReader ends;
  WriterToReader user;
};

}  // namespace ddssec::cryptography::trusting_host
