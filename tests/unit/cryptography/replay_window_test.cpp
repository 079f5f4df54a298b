#include "plugins/cryptography/replay_window.hpp"

#include <gtest/gtest.h>

#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

Iv iv(std::uint32_t session, std::uint64_t suffix) {
  Iv out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(session >> (24 - 8 * i));
  for (std::size_t i = 0; i < 8; ++i)
    out[4 + i] = static_cast<std::uint8_t>(suffix >> (56 - 8 * i));
  return out;
}

TEST(ReplayWindow, AMessage_ComingTwice_IsRefused) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(iv(7, 100)));
  EXPECT_FALSE(window.accept(iv(7, 100)));
  EXPECT_TRUE(window.accept(iv(7, 4000)));
  EXPECT_FALSE(window.accept(iv(7, 100)));
  EXPECT_FALSE(window.accept(iv(7, 4000)));
}

TEST(ReplayWindow, LateMessages_AreAcceptedOnce) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(iv(7, 5000)));
  for (std::uint64_t late = 1; late < ReplayWindow::kMaxLate; ++late) {
    EXPECT_TRUE(window.accept(iv(7, 5000 - late)));
    EXPECT_FALSE(window.accept(iv(7, 5000 - late)));
  }
  EXPECT_FALSE(window.accept(iv(7, 5000)));
}

TEST(ReplayWindow, AMessage_LaterThanTheWindow_IsRefused) {
  ReplayWindow window;
  for (std::uint64_t n = 0; n < ReplayWindow::kMaxLate; ++n)
    EXPECT_TRUE(window.accept(iv(7, 1000 + 10 * n)));
  EXPECT_TRUE(window.accept(iv(7, 995))) << "nothing has left the window yet";
  for (const std::uint64_t late : {990, 995}) EXPECT_FALSE(window.accept(iv(7, late)));
  EXPECT_TRUE(window.accept(iv(7, 1000 + 10 * ReplayWindow::kMaxLate))) << "in place of 1000";
  EXPECT_FALSE(window.accept(iv(7, 999)));
  for (std::uint64_t n = 0; n <= ReplayWindow::kMaxLate; ++n)
    EXPECT_FALSE(window.accept(iv(7, 1000 + 10 * n)));
  EXPECT_TRUE(window.accept(iv(7, 1001)));
}

// A receiver reads two sockets in turn, and one of them has a long backlog.
TEST(ReplayWindow, ABacklog_BesideNewerMessages_IsAccepted) {
  ReplayWindow window;
  for (std::uint64_t n = 0; n < 200; ++n) EXPECT_TRUE(window.accept(iv(7, 100'000 + n)));
  for (std::uint64_t n = 0; n < 5000; ++n) {
    EXPECT_TRUE(window.accept(iv(7, n)));
    EXPECT_FALSE(window.accept(iv(7, n)));
  }
  for (std::uint64_t n = 0; n < 200; ++n) EXPECT_FALSE(window.accept(iv(7, 100'000 + n)));
}

TEST(ReplayWindow, Sessions_CountUpInOneOrder) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(iv(0xffffffff, 900)));
  EXPECT_TRUE(window.accept(iv(0, 3))) << "session ids count past the greatest";
  EXPECT_FALSE(window.accept(iv(0, 3)));
  EXPECT_TRUE(window.accept(iv(0xffffffff, 901))) << "late";
  EXPECT_FALSE(window.accept(iv(0xffffffff, 901)));
  for (std::uint64_t n = 0; n < ReplayWindow::kMaxLate; ++n) EXPECT_TRUE(window.accept(iv(2, n)));
  EXPECT_FALSE(window.accept(iv(0, 2)));
  EXPECT_FALSE(window.accept(iv(0, 3)));
  EXPECT_TRUE(window.accept(iv(1, 0))) << "newer than all that have left the window";
}

TEST(ReplayWindow, Suffixes_CountPastTheGreatest) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(iv(7, ~std::uint64_t{0})));
  EXPECT_TRUE(window.accept(iv(7, 1)));
  EXPECT_FALSE(window.accept(iv(7, ~std::uint64_t{0})));
  EXPECT_FALSE(window.accept(iv(7, 1)));
}

// A child of fork() begins at a random number, and its parent goes on.
TEST(ReplayWindow, ParentAndChildren_AreHeardBesideOneAnother) {
  ReplayWindow window;
  constexpr std::uint32_t kApart = 0x10000000;
  for (std::uint32_t n = 0; n < 3; ++n)
    for (std::uint32_t stream = 0; stream < ReplayWindow::kMaxStreams; ++stream) {
      EXPECT_TRUE(window.accept(iv(stream * kApart, n)));
      EXPECT_FALSE(window.accept(iv(stream * kApart, n)));
    }
  EXPECT_FALSE(window.accept(iv(ReplayWindow::kMaxStreams * kApart, 0)));
}

// ---- in the plugin

using spi::ProtectionKind;

struct RepeatedMessages : ::testing::Test {
  Bytes sent() {
    const auto message = testing::DataMessage{.number = ++number}.octets();
    return testing::encode_submessage(two, ends, message).value();
  }
  Result<Bytes> got(const Bytes& encoded) { return testing::decode_submessage(two, ends, encoded); }
  void begin(ProtectionKind kind) {
    ends = two.endpoints(testing::endpoint_attributes(kind, ProtectionKind::none));
  }

  std::uint32_t number = 0;
  testing::TwoSides two{ProtectionKind::none};
  testing::WriterToReader ends;
};

TEST_F(RepeatedMessages, MessageWithOriginAuthentication_CountsOnce) {
  for (const auto kind : {ProtectionKind::encrypt_with_origin_authentication,
                          ProtectionKind::sign_with_origin_authentication}) {
    begin(kind);
    const auto first = sent(), second = sent();
    EXPECT_TRUE(got(second));
    EXPECT_TRUE(got(first)) << "late, but new";
    EXPECT_EQ(testing::code_of(got(first)), Code::message_repeated);
    EXPECT_EQ(testing::code_of(got(second)), Code::message_repeated);
    EXPECT_TRUE(got(sent()));
  }
}

TEST_F(RepeatedMessages, TheSameKeyOnceMore_MakesNothingNew) {
  begin(ProtectionKind::encrypt_with_origin_authentication);
  const auto first = sent();
  EXPECT_TRUE(got(first));
  const auto under_way = sent();
  two.take_writer(ends, two.writer_tokens(ends).value()).value();
  EXPECT_EQ(testing::code_of(got(first)), Code::message_repeated);
  EXPECT_TRUE(got(under_way));
}

// Each reader has the key, and could use IVs that the writer has not reached yet.
TEST_F(RepeatedMessages, MessageWithoutOriginAuthentication_IsNotJudged) {
  begin(ProtectionKind::encrypt);
  const auto first = sent();
  EXPECT_TRUE(got(first));
  EXPECT_TRUE(got(first));
}

// Two receivers in one process, in each of which the host takes each message once.
struct MessagesRepeatedElsewhere : ::testing::Test {
  static constexpr auto kOrigin = ProtectionKind::encrypt_with_origin_authentication;

  // Returns the answers of the two readers to one message of the writer, one after the other.
  std::pair<Code, Code> both_readers(const CryptographyOptions& options) {
    testing::TwoSides two(ProtectionKind::none, {}, options);
    const auto attributes = testing::endpoint_attributes(kOrigin, ProtectionKind::none);
    const auto first = two.endpoints(attributes);
    auto second = first;
    second.reader =
        two.b.factory().register_local_datareader(two.b.participant, {}, attributes).value();
    two.match_endpoints(second);
    const spi::DatareaderCryptoHandle readers[] = {first.remote_reader, second.remote_reader};
    const auto plain = testing::DataMessage{.writer = {{0, 0, 1, 2}}}.octets();
    const auto message =
        testing::into_bytes(plain.size() + spi::protection_overhead(2), [&](MutableBytes out) {
          return two.a.transform().encode_datawriter_submessage(first.writer, readers, plain, out);
        }).value();
    const auto one = testing::decode_submessage(two, first, message);
    return {testing::code_of(one),
            testing::code_of(testing::decode_submessage(two, second, message))};
  }

  // Returns the answers of two participants of one process to one RTPS message.
  std::pair<Code, Code> both_participants(const CryptographyOptions& options) {
    testing::TwoSides two(kOrigin, {}, options);
    auto& a = two.a;
    auto& b = two.b;
    const auto second =
        b.factory()
            .register_local_participant({2}, {2}, {}, testing::participant_attributes(kOrigin))
            .value();
    const auto secret = testing::shared_secret(9);
    const auto at_a =
        a.factory().register_matched_remote_participant(a.participant, {8}, {8}, secret).value();
    const auto at_b =
        b.factory().register_matched_remote_participant(second, {7}, {7}, secret).value();
    const auto tokens =
        a.exchange().create_local_participant_crypto_tokens(a.participant, at_a).value();
    b.exchange().set_remote_participant_crypto_tokens(second, at_b, tokens).value();
    const spi::ParticipantCryptoHandle receivers[] = {a.remote, at_a};
    const auto plain = testing::rtps_message({testing::data_submessage(32)});
    const auto message =
        testing::into_bytes(plain.size() + spi::protection_overhead(2), [&](MutableBytes out) {
          return a.transform().encode_rtps_message(a.participant, receivers, plain, out);
        }).value();
    const auto one = testing::decode_message(two, message);
    const auto other = testing::into_bytes(message.size(), [&](MutableBytes out) {
      return b.transform().decode_rtps_message(second, at_b, message, out);
    });
    return {testing::code_of(one), testing::code_of(other)};
  }
};

TEST_F(MessagesRepeatedElsewhere, HostThatTakesEachMessageOnce_IsToldByTheSecondReader) {
  EXPECT_EQ(both_readers({.host_checks_sources = false}),
            std::pair(Code{}, Code::message_repeated));
}

TEST_F(MessagesRepeatedElsewhere, HostThatTakesEachMessageOnce_IsToldByTheSecondParticipant) {
  EXPECT_EQ(both_participants({.host_checks_sources = false}),
            std::pair(Code{}, Code::message_repeated));
}

TEST_F(MessagesRepeatedElsewhere, HostThatAsksForEachPlace_GetsItForBoth) {
  EXPECT_EQ(both_readers({.host_checks_sources = true}), std::pair(Code{}, Code{}));
  EXPECT_EQ(both_participants({.host_checks_sources = true}), std::pair(Code{}, Code{}));
}

}  // namespace
}  // namespace ddssec::cryptography
