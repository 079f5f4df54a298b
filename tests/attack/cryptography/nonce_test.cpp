// No IV is used twice under one key (T40 in docs/attacks.md), with small limits, many threads, and
// every key.
#include <algorithm>
#include <barrier>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kNone = ProtectionKind::none;

// The key id, session id and suffix in a CryptoHeader.
using Nonce = std::array<std::uint8_t, 16>;

Nonce nonce_at(const Bytes& encoded, std::size_t header) {
  Nonce nonce;
  std::copy_n(encoded.begin() + static_cast<std::ptrdiff_t>(header) + 4, 16, nonce.begin());
  return nonce;
}

// Runs `encode` in four threads at once. Returns all nonces that they used, sorted.
template <class Encode>
std::vector<Nonce> nonces_of_four_threads(int messages, Encode&& encode) {
  std::vector<std::vector<Nonce>> seen(4);
  std::barrier start(4);
  std::vector<std::thread> threads;
  for (auto& mine : seen)
    threads.emplace_back([&] {
      start.arrive_and_wait();
      for (int i = 0; i < messages; ++i) mine.push_back(encode(static_cast<std::size_t>(i)));
    });
  for (auto& thread : threads) thread.join();
  std::vector<Nonce> all;
  for (const auto& mine : seen) all.insert(all.end(), mine.begin(), mine.end());
  std::ranges::sort(all);
  return all;
}

std::size_t sessions(const std::vector<Nonce>& nonces) {
  std::set<std::array<std::uint8_t, 4>> ids;
  for (const auto& nonce : nonces) ids.insert({nonce[4], nonce[5], nonce[6], nonce[7]});
  return ids.size();
}

class Nonces : public ::testing::TestWithParam<std::tuple<std::uint64_t, std::string_view>> {
 protected:
  static std::uint64_t limit() { return std::get<0>(GetParam()); }
  static CryptographyOptions options() { return {.max_blocks_per_session = limit()}; }
  static PropertyList properties() { return cipher(std::get<1>(GetParam()), true); }
  static constexpr int kMessages = 3000;
};

TEST_P(Nonces, OneWriterInFourThreads_NeverRepeatsANonce) {
  TwoSides two(kNone, properties(), options());
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  const auto all = nonces_of_four_threads(kMessages, [&](std::size_t i) {
    return nonce_at(encode_payload(two, e, Bytes(i % 100, 1)).value(), 0);
  });
  EXPECT_EQ(std::ranges::adjacent_find(all), all.end());
  EXPECT_EQ(all.size(), 4u * kMessages);
  if (limit() < 1000) {
    EXPECT_GT(sessions(all), 100u);
  }
  EXPECT_TRUE(decode_payload(two, e, encode_payload(two, e, Bytes(8)).value()));
}

TEST_P(Nonces, OneParticipantWithReceivers_NeverRepeatsANonce) {
  TwoSides two(ProtectionKind::encrypt_with_origin_authentication, properties(), options());
  const auto plain = rtps_message({data_submessage(40)});
  const auto all = nonces_of_four_threads(kMessages / 4, [&](std::size_t) {
    const auto encoded = encode_message(two, plain).value();
    EXPECT_TRUE(is_decoded_or_late(decode_message(two, encoded))) << "also while sessions change";
    return nonce_at(encoded, 24);
  });
  EXPECT_EQ(std::ranges::adjacent_find(all), all.end());
}

// The writer and the reader of a pair's volatile channel encrypt with the same key.
TEST_P(Nonces, BothVolatileEndpoints_NeverRepeatANonce) {
  TwoSides two(kNone, properties(), options());
  auto writing = two.volatile_endpoints();
  auto& a = two.a;
  const auto reader =
      a.factory()
          .register_local_datareader(a.participant, builtin_endpoint(kVolatileReader), {})
          .value();
  const auto remote_writer =
      a.factory().register_matched_remote_datawriter(reader, a.remote, shared_secret()).value();
  const auto all = nonces_of_four_threads(kMessages, [&](std::size_t i) {
    Bytes out(200);
    const auto plain = data_submessage(20, i % 2 == 0 ? 0x07 : 0x06);
    const auto size = i % 2 == 0 ? a.transform().encode_datawriter_submessage(
                                       writing.writer, {&writing.remote_reader, 1}, plain, out)
                                 : a.transform().encode_datareader_submessage(
                                       reader, {&remote_writer, 1}, plain, out);
    EXPECT_TRUE(size);
    return nonce_at(out, 4);
  });
  EXPECT_EQ(std::ranges::adjacent_find(all), all.end());
}

INSTANTIATE_TEST_SUITE_P(Limits, Nonces,
                         ::testing::Combine(::testing::Values(1, 2, 7, 64, std::uint64_t{1} << 32),
                                            ::testing::Values(spi::kAes256Name,
                                                              spi::kChaCha20Poly1305Name)));

class Sessions : public ::testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(Ciphers, Sessions,
                         ::testing::Values(spi::kAes256Name, spi::kChaCha20Poly1305Name));

TEST_P(Sessions, SessionAtItsLimit_RollsOverAndNotBefore) {
  TwoSides two(kNone, cipher(GetParam()), {.max_blocks_per_session = 12});
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  std::vector<Nonce> nonces;
  for (int i = 0; i < 7; ++i)  // 4 blocks each, so 3 in a session
    nonces.push_back(nonce_at(encode_payload(two, e, Bytes(32)).value(), 0));
  EXPECT_EQ(sessions({nonces.begin(), nonces.begin() + 3}), 1u);
  EXPECT_EQ(sessions({nonces.begin(), nonces.begin() + 6}), 2u);
  EXPECT_EQ(sessions(nonces), 3u);
}

TEST_P(Sessions, AMessageLargerThanASession_IsAloneInIt) {
  TwoSides two(kNone, cipher(GetParam()), {.max_blocks_per_session = 4});
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  std::vector<Nonce> nonces;
  for (int i = 0; i < 3; ++i) {
    const auto encoded = encode_payload(two, e, Bytes(5000, 9)).value();
    nonces.push_back(nonce_at(encoded, 0));
    EXPECT_EQ(decode_payload(two, e, encoded).value(), Bytes(5000, 9));
  }
  EXPECT_EQ(sessions(nonces), 3u);
}

TEST_P(Sessions, SessionsUsedUp_EndWithAnErrorAndDoNotRepeat) {
  TwoSides two(kNone, cipher(GetParam()), {.max_blocks_per_session = 2, .max_sessions_per_key = 3});
  const auto e = two.endpoints(endpoint_attributes(kNone, kEncrypt));
  std::set<Nonce> nonces;
  for (int i = 0; i < 3; ++i) nonces.insert(nonce_at(encode_payload(two, e, Bytes(8)).value(), 0));
  EXPECT_EQ(nonces.size(), 3u);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(encode_payload(two, e, Bytes(8)).error().code(), Code::session_ids_exhausted);
}

TEST_P(Sessions, RestartedSender_StartsElsewhere) {
  std::set<std::array<std::uint8_t, 12>> starts;
  for (int i = 0; i < 50; ++i) {
    TwoSides two(kEncrypt, cipher(GetParam(), true));
    const auto encoded = encode_message(two, rtps_message({data_submessage(8)})).value();
    std::array<std::uint8_t, 12> iv;
    std::copy_n(encoded.begin() + 32, 12, iv.begin());
    starts.insert(iv);
  }
  EXPECT_EQ(starts.size(), 50u);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
