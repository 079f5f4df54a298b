// One plaintext for all local participants that matched a sender: which calls are for the message
// that was just opened, and which are not.
#include <functional>
#include <thread>

#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

using testing::_;

constexpr auto kAskNext = DDS_SECURITY_ERR_INVALID_CRYPTO_RECEIVER_SIGN_CODE;

struct OpenedMessageTest : testing::Test {
  using Own = Harness<CryptographyAdapter, MockCryptography, spi::Cryptography>;

  OpenedMessageTest() {
    for (auto* one : {&harness, &other_domain})
      ON_CALL(*one->plugin, decode_rtps_message)
          .WillByDefault([this](auto, auto, BytesView, MutableBytes) -> Result<std::size_t> {
            ++opened;
            if (code != Code{}) return fail(code);
            return 40;
          });
  }

  // Returns 0 if the message was opened, otherwise the host's code.
  int decode(int receiver = 1, int sender = 9, Own* domain = nullptr) {
    auto* transform = (domain != nullptr ? *domain : harness).adapter.crypto_transform;
    HostBlock plain;
    Refusal refusal;
    const bool done = transform->decode_rtps_message(transform, &plain, &message.sequence, receiver,
                                                     sender, &refusal) != 0;
    EXPECT_EQ(plain._buffer != nullptr, done);
    if (refusal.code == kAskNext) was_silent = refusal.message == nullptr;
    return done ? 0 : refusal.code;
  }
  // True if the message is opened again for another receiver that asks.
  bool opens_again(const std::function<int()>& ask) {
    OpenedMessage::of_this_thread().forget();
    EXPECT_EQ(decode(), 0);
    const auto before = opened;
    const auto result = ask();
    EXPECT_TRUE(result == 0 || result == kAskNext);
    EXPECT_EQ(opened - before, result == 0 ? 1 : 0);
    return result == 0;
  }

  Own harness, other_domain;
  HostOctets message{Bytes(200, 1)};
  int opened = 0;
  bool was_silent = false;
  Code code{};
};

TEST_F(OpenedMessageTest, ManyReceivers_OpenItOnce) {
  EXPECT_EQ(decode(1), 0);
  for (const int receiver : {2, 3, 2}) {
    EXPECT_EQ(decode(receiver), kAskNext);
    EXPECT_TRUE(was_silent) << "nothing to format, nothing to log";
  }
  EXPECT_EQ(opened, 1);
  EXPECT_TRUE(harness.events.empty());
}

TEST_F(OpenedMessageTest, HostsEarlierResult_StaysWhereItIs) {
  auto* transform = harness.adapter.crypto_transform;
  HostBlock plain;
  ASSERT_EQ(transform->decode_rtps_message(transform, &plain, &message.sequence, 1, 9, nullptr), 1);
  const auto* const first = plain._buffer;
  EXPECT_EQ(transform->decode_rtps_message(transform, &plain, &message.sequence, 2, 9, nullptr), 0);
  EXPECT_EQ(plain._buffer, first);
  EXPECT_EQ(plain._length, 40u);
}

TEST_F(OpenedMessageTest, TheSameReceiver_MayAskAgain) {
  EXPECT_TRUE(opens_again([&] { return decode(1); })) << "a datagram that came twice";
  EXPECT_FALSE(opens_again([&] { return decode(2); }));
}

TEST_F(OpenedMessageTest, AnotherSenderDomainAddressOrLength_IsAnotherMessage) {
  EXPECT_TRUE(opens_again([&] { return decode(2, 8); }));
  EXPECT_TRUE(opens_again([&] { return decode(2, 9, &other_domain); }));
  const auto moved = message.octets;
  EXPECT_TRUE(opens_again([&] {
    const HostOctets elsewhere(moved);
    auto* transform = harness.adapter.crypto_transform;
    HostBlock plain;
    return transform->decode_rtps_message(transform, &plain, &elsewhere.sequence, 2, 9, nullptr) -
           1;
  }));
  EXPECT_TRUE(opens_again([&] {
    message.sequence._length -= 4;
    return decode(2);
  }));
}

TEST_F(OpenedMessageTest, OtherOctetsAtTheSameAddress_AreAnotherMessage) {
  // The places are in the RTPS header, SRTPS_PREFIX, the two parts of the IV, the tag, and the last
  // receiver-specific MAC.
  for (const std::size_t at : {8u, 20u, 32u, 43u, 164u, 184u, 199u})
    EXPECT_TRUE(opens_again([&] {
      message.octets[at] ^= 1;
      return decode(2);
    })) << at;
}

TEST_F(OpenedMessageTest, ARefusedMessage_WasNotOpened) {
  code = Code::tag_mismatch;
  EXPECT_EQ(decode(1), static_cast<int>(Code::tag_mismatch));
  EXPECT_EQ(decode(2), static_cast<int>(Code::tag_mismatch));
  // For this code the host asks for the next participant, which opens the message.
  code = Code::receiver_specific_mac_missing;
  EXPECT_EQ(decode(1), kAskNext);
  code = Code{};
  EXPECT_EQ(decode(2), 0);
  EXPECT_EQ(decode(3), kAskNext);
  EXPECT_EQ(opened, 4);
}

TEST_F(OpenedMessageTest, OneTooShortForAnIvAndATag_IsNotRemembered) {
  message.sequence._length = 79;
  EXPECT_TRUE(opens_again([&] { return decode(2); }));
  message.sequence._length = 80;
  EXPECT_FALSE(opens_again([&] { return decode(2); }));
}

TEST_F(OpenedMessageTest, AnotherThread_KnowsNothingOfIt) {
  EXPECT_TRUE(opens_again([&] {
    int result = -1;
    std::thread([&] { result = decode(2); }).join();
    return result;
  }));
}

TEST_F(OpenedMessageTest, AnyOtherCallOfTheThread_EndsIt) {
  auto* transform = harness.adapter.crypto_transform;
  auto* exchange = harness.adapter.crypto_key_exchange;
  auto* factory = harness.adapter.crypto_key_factory;
  const std::function<void(HostBlock&)> others[] = {
      [&](auto& out) {
        transform->encode_serialized_payload(transform, &out, nullptr, &message.sequence, 1,
                                             nullptr);
      },
      [&](auto& out) {
        transform->decode_datawriter_submessage(transform, &out, &message.sequence, 1, 2, nullptr);
      },
      [&](auto&) {
        exchange->set_remote_participant_crypto_tokens(exchange, 1, 2, nullptr, nullptr);
      },
      [&](auto&) { factory->unregister_participant(factory, 1, nullptr); },
  };
  for (const auto& other : others)
    EXPECT_TRUE(opens_again([&] {
      HostBlock out;
      other(out);
      return decode(2);
    }));
}

TEST_F(OpenedMessageTest, SenderWithoutKeysHere_MayHaveSentThemToTheNext) {
  code = Code::key_material_not_received;
  EXPECT_EQ(decode(1), kAskNext);
  code = Code{};
  EXPECT_EQ(decode(2), 0);
}

}  // namespace
}  // namespace ddssec::cyclonedds
