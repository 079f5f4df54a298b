// What the tests of pki/ share: a clock reading, authorities, files of tests/data.
#pragma once

#include <fstream>
#include <iterator>
#include <string>

#include <gtest/gtest.h>

#include "base/clock.hpp"
#include "pki/authority.hpp"
#include "pki/chain.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/test_ca.hpp"
#include "tests/support/test_data.hpp"

namespace ddssec::pki {

using namespace std::chrono_literals;

/// 2026-11-21T00:00:00Z, a day on which everything made here is valid.
using test::kNow;
using test::kYear;
using test::make_ca;
using test::make_leaf;
using test::test_random;

inline ChainVerifier make_verifier(std::vector<Certificate> anchors, std::vector<Crl> crls = {},
                                   CrlPolicy policy = CrlPolicy::hard_fail) {
  auto verifier = ChainVerifier::make(std::move(anchors), std::move(crls), policy);
  EXPECT_TRUE(verifier) << verifier.error().to_sentence();
  return *std::move(verifier);
}

/// Reads a file below tests/data.
inline Bytes data_file(const std::string& name) {
  std::ifstream in(test::data_path(name), std::ios::binary);
  EXPECT_TRUE(in) << name;
  return Bytes(std::istreambuf_iterator<char>(in), {});
}

inline Bytes bytes(std::string_view text) { return to_bytes(as_bytes(text)); }

/// Returns the base64 text of `octets` in one line.
inline std::string base64(BytesView octets) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t at = 0; at < octets.size(); at += 3) {
    const auto octet = [&](std::size_t i) { return at + i < octets.size() ? octets[at + i] : 0u; };
    const auto bits = octet(0) << 16 | octet(1) << 8 | octet(2);
    for (std::size_t i = 0; i < 4; ++i)
      out += at + i <= octets.size() ? kDigits[bits >> (18 - 6 * i) & 63] : '=';
  }
  return out;
}

/// Returns `text` with the first `from` replaced. The text must contain it.
inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return at == text.npos ? text : text.replace(at, from.size(), to);
}

}  // namespace ddssec::pki
