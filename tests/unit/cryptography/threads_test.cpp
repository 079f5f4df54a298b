// Keys and entities come and go while other threads send and receive.
#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kOrigin = ProtectionKind::encrypt_with_origin_authentication;

// Runs `work` in threads until `rounds` calls of `change` are done.
template <class Work, class Change>
void while_changing(int rounds, Work&& work, Change&& change) {
  std::atomic<bool> done = false;
  std::vector<std::thread> threads;
  for (int i = 0; i < 3; ++i)
    threads.emplace_back([&] {
      while (!done.load()) work();
    });
  for (int i = 0; i < rounds; ++i) change(i);
  done = true;
  for (auto& thread : threads) thread.join();
}

class CryptographyThreads : public ::testing::TestWithParam<AeadChoice> {
 protected:
  static CryptographyOptions options() {
    return {.aead = GetParam(), .max_blocks_per_session = 64};
  }
};

TEST_P(CryptographyThreads, TokensComingAgain_DisturbNoDecoding) {
  TwoSides two(kOrigin, {}, options());
  const auto e = two.endpoints(endpoint_attributes(kOrigin, kEncrypt));
  const auto plain = data_submessage(40);
  const auto tokens = two.writer_tokens(e).value();
  while_changing(
      300,
      [&] {
        const auto decoded = decode_submessage(two, e, encode_submessage(two, e, plain).value());
        EXPECT_TRUE(is_decoded_or_late(decoded));
        EXPECT_TRUE(!decoded || *decoded == plain);
        EXPECT_TRUE(decode_payload(two, e, encode_payload(two, e, plain).value()));
        EXPECT_TRUE(is_decoded_or_late(
            decode_message(two, encode_message(two, rtps_message({plain})).value())));
      },
      [&](int) {
        two.take_writer(e, tokens).value();
        two.exchange_participant_tokens();
      });
}

TEST_P(CryptographyThreads, EntitiesThatGoWhileInUse_DoNoHarm) {
  TwoSides two(kOrigin, {}, options());
  const auto attributes = endpoint_attributes(kOrigin, kEncrypt);
  const auto fixed = two.endpoints(attributes);
  // Handles in use are unregistered. A host should not do this, but it must do no harm.
  WriterToReader e = two.endpoints(attributes);
  std::array<std::atomic<std::int64_t>, 4> handles = {e.writer.value, e.remote_reader.value,
                                                      e.reader.value, e.remote_writer.value};
  const auto plain = data_submessage(40);
  while_changing(
      100,
      [&] {
        const WriterToReader now{{handles[0]}, {handles[1]}, {handles[2]}, {handles[3]}};
        if (const auto encoded = encode_submessage(two, now, plain))
          (void)decode_submessage(two, now, *encoded);
        const auto encoded = encode_submessage(two, fixed, plain);
        (void)two.b.transform().preprocess_secure_submessage({}, two.b.remote, *encoded);
        EXPECT_TRUE(is_decoded_or_late(decode_submessage(two, fixed, *encoded)));
      },
      [&](int) {
        two.a.factory().unregister_datawriter(e.writer).value();
        two.b.factory().unregister_datareader(e.reader).value();
        e = two.endpoints(attributes);
        handles[0] = e.writer.value, handles[1] = e.remote_reader.value;
        handles[2] = e.reader.value, handles[3] = e.remote_writer.value;
      });
}

TEST_P(CryptographyThreads, ParticipantsThatGoWhileInUse_DoNoHarm) {
  TwoSides two(kOrigin, {}, options());
  const auto encoded = encode_message(two, rtps_message({data_submessage(40)})).value();
  const auto decode = [&] {
    Bytes out(encoded.size());
    auto size =
        two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, encoded, out);
    if (size) out.resize(*size);
    return size ? std::optional(out) : std::nullopt;
  };
  const auto expected = decode();
  ASSERT_TRUE(expected);
  while_changing(
      100,
      [&] {
        const auto decoded = decode();
        EXPECT_TRUE(!decoded || *decoded == *expected);
      },
      [&](int i) {
        if (i % 2 == 0) {
          TwoSides::match(two.b, static_cast<std::uint8_t>(i));
          two.exchange_participant_tokens();
        } else if (i == 99) {
          two.b.factory().unregister_participant(two.b.remote).value();
        }
      });
  EXPECT_FALSE(decode()) << "of a participant that is gone";
}

INSTANTIATE_TEST_SUITE_P(Backends, CryptographyThreads,
                         ::testing::Values(AeadChoice::automatic, AeadChoice::openssl),
                         [](const auto& info) {
                           return info.param == AeadChoice::automatic ? "automatic" : "openssl";
                         });

}  // namespace
}  // namespace ddssec::cryptography::testing
