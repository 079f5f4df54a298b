// A process forks while its keys are in use. No two of the processes use the same IV.
#include "plugins/cryptography/fork_generation.hpp"

#include <array>
#include <functional>
#include <memory>
#include <set>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/send_key.hpp"
#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOrigin = ProtectionKind::encrypt_with_origin_authentication;

// Runs `work` in a child of fork(), and `meanwhile` in the parent. Returns the child's result.
Bytes from_child(const std::function<Bytes()>& work, const std::function<void()>& meanwhile = {}) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const auto child = fork();
  if (child == 0) {
    const auto said = work();
    const auto written = write(ends[1], said.data(), said.size());  // less than a pipe holds
    _exit(written == static_cast<ssize_t>(said.size()) ? 0 : 1);
  }
  close(ends[1]);
  if (meanwhile) meanwhile();
  Bytes said(65536);
  std::size_t size = 0;
  while (const auto got = read(ends[0], said.data() + size, said.size() - size)) {
    if (got < 0) break;
    size += static_cast<std::size_t>(got);
  }
  close(ends[0]);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  said.resize(size);
  return said;
}

// Sends one message of each kind that a participant sends, and knows where its CryptoHeader stands.
struct Speaker {
  static constexpr std::size_t kKinds = 5, kRound = 8;
  static constexpr std::array<std::size_t, kKinds> kHeaderAt = {0, 4, 4, 24, 24};

  Speaker() {
    const PropertyList passphrase = {
        {std::string(spi::property::kPskPassphrase), "data:,1:Open Sesame"}};
    ParticipantSecurityAttributes attributes;
    attributes.rtps_psk = kEncrypt;
    for (auto* keys : {&keys_of_a, &keys_of_b})
      *keys = two.a.factory().pre_shared_keys({passphrase, attributes, 7, ""}).value();
  }

  Result<Bytes> say(std::size_t kind) {
    const auto data = data_submessage(60);
    const auto message = rtps_message({data});
    switch (kind) {
      case 0:
        return encode_payload(two, user, data);
      case 1:
        return encode_submessage(two, user, data);
      case 2:
        return encode_submessage(two, exchange, data_submessage(60, 0x07));
      case 3:
        return encode_message(two, message);
      default:
        return into_bytes(message.size() + spi::protection_overhead(0),
                          [&](MutableBytes out) { return keys_of_a->encode(message, out); });
    }
  }
  Status understand(std::size_t kind, BytesView said) {
    const auto understood = [&]() -> Result<Bytes> {
      switch (kind) {
        case 0:
          return decode_payload(two, user, said);
        case 1:
          return decode_submessage(two, user, said);
        case 2:
          return decode_submessage(two, exchange, said);
        case 3:
          return decode_message(two, said);
        default:
          return into_bytes(said.size(),
                            [&](MutableBytes out) { return keys_of_b->decode(said, out); });
      }
    }();
    return understood ? Status{} : std::unexpected(understood.error());
  }

  // Returns several messages of each kind, one after another.
  Bytes speech() {
    Bytes out;
    for (std::size_t i = 0; i < kRound * kKinds; ++i) {
      const auto said = say(i % kKinds).value();
      out.push_back(static_cast<std::uint8_t>(said.size()));
      out.push_back(static_cast<std::uint8_t>(said.size() >> 8));
      out.insert(out.end(), said.begin(), said.end());
    }
    return out;
  }
  // Expects that all messages can be opened, and that no key meets an IV a second time.
  void expect_new_ivs(BytesView speech) {
    std::size_t count = 0;
    for (; !speech.empty(); ++count) {
      const auto size = static_cast<std::size_t>(speech[0] | speech[1] << 8);
      const auto said = speech.subspan(2, size);
      speech = speech.subspan(2 + size);
      const auto kind = count % kKinds;
      const auto header = to_bytes(said.subspan(kHeaderAt[kind], kCryptoHeaderSize));
      EXPECT_TRUE(headers.insert(header).second) << kind << " repeats " << to_hex(header);
      const auto status = understand(kind, said);
      EXPECT_TRUE(status) << kind << ": " << status.error().to_sentence();
    }
    EXPECT_EQ(count, kRound * kKinds);
  }

  TwoSides two{kEncryptOrigin};
  WriterToReader user = two.endpoints(endpoint_attributes(kEncryptOrigin, kEncrypt));
  WriterToReader exchange = two.volatile_endpoints();
  std::unique_ptr<spi::PreSharedKeys> keys_of_a, keys_of_b;
  std::set<Bytes> headers;
};

TEST(ForkedSender, ParentAndChild_NeverUseOneIvTwice) {
  Speaker speaker;
  speaker.expect_new_ivs(speaker.speech());
  Bytes of_parent;
  const auto of_child =
      from_child([&] { return speaker.speech(); }, [&] { of_parent = speaker.speech(); });
  speaker.expect_new_ivs(of_parent);
  speaker.expect_new_ivs(of_child);
  speaker.expect_new_ivs(speaker.speech());
}

TEST(ForkedSender, TwoChildrenAndAGrandchild_NeverUseOneIvTwice) {
  Speaker speaker;
  speaker.expect_new_ivs(speaker.speech());
  for (int child = 0; child < 2; ++child)
    speaker.expect_new_ivs(from_child([&] { return speaker.speech(); }));
  speaker.expect_new_ivs(from_child([&] { return from_child([&] { return speaker.speech(); }); }));
  // This child sends messages before its own child does.
  const auto both = from_child([&] {
    auto said = speaker.speech();
    const auto childs = from_child([&] { return speaker.speech(); });
    said.insert(said.end(), childs.begin(), childs.end());
    return said;
  });
  const auto half = both.size() / 2;
  speaker.expect_new_ivs(BytesView(both).first(half));
  speaker.expect_new_ivs(BytesView(both).subspan(half));
}

// The first session of the key begins with its first message, which both processes may send.
TEST(ForkedSender, KeyWithoutMessagesBefore_BeginsElsewhereInTheChild) {
  Speaker speaker;
  Bytes of_parent;
  const auto of_child =
      from_child([&] { return speaker.speech(); }, [&] { of_parent = speaker.speech(); });
  speaker.expect_new_ivs(of_parent);
  speaker.expect_new_ivs(of_child);
}

TEST(ForkedSender, AChild_KnowsWhatItsParentSaidFromThePeersWords) {
  Speaker speaker;
  const auto before = speaker.say(2).value();
  const auto codes = from_child([&] {
    const auto own = speaker.say(2).value();
    Bytes out;
    for (const auto* said : {&before, &own}) {
      const auto code =
          static_cast<std::uint32_t>(code_of(decode_reply(speaker.two, speaker.exchange, *said)));
      out.push_back(static_cast<std::uint8_t>(code));
      out.push_back(static_cast<std::uint8_t>(code >> 8));
    }
    return out;
  });
  const auto expected = static_cast<std::uint32_t>(Code::key_exchange_reflected);
  const auto low = static_cast<std::uint8_t>(expected),
             high = static_cast<std::uint8_t>(expected >> 8);
  EXPECT_EQ(codes, (Bytes{low, high, low, high}));
}

// Gives random octets until it is broken.
struct BreakableRandom final : Random {
  Status fill(MutableBytes out) override {
    if (is_broken) return ddssec::fail(Code::random_failed);
    return system.fill(out);
  }
  SystemRandom system;
  bool is_broken = false;
};

TEST(ForkedSender, AChildWithoutRandomOctets_SendsNothing) {
  BreakableRandom random;
  RetiredObjects retired_objects;
  const KeyServices services{*aead_backend(AeadChoice::automatic), retired_objects, 1000, 1000,
                             random};
  KeyMaterial material{.kind = kAes256Gcm};
  material.salt = MasterSalt::copy_of(Bytes(32, 1)).value();
  material.sender_key = MasterKey::copy_of(Bytes(32, 2)).value();
  const auto key = SendKey::create(std::move(material), {1, 1}, services).value();
  random.is_broken = true;
  const auto reserve = [&] {
    const ReadGuard guard;
    return code_of(key->reserve(64));
  };
  const auto refusals = from_child([&] {
    Bytes out;
    for (int i = 0; i < 2; ++i) out.push_back(reserve() == Code::random_failed);
    random.is_broken = false;
    out.push_back(reserve() == Code{});
    return out;
  });
  EXPECT_EQ(refusals, (Bytes{1, 1, 1}));
  EXPECT_EQ(reserve(), Code{});  // the parent needs no random octets
}

using Detection = ForkGeneration::Detection;
class ForkBy : public ::testing::TestWithParam<Detection> {};
INSTANTIATE_TEST_SUITE_P(EachMeans, ForkBy,
                         ::testing::Values(Detection::kernel_if_possible, Detection::handler));

TEST_P(ForkBy, EveryProcessOfALine_HasAGenerationOfItsOwn) {
  // The handler of fork() cannot be removed, so its object must live as long.
  static auto& kept = *new std::vector<std::unique_ptr<ForkGeneration>>;
  auto& generation = *kept.emplace_back(std::make_unique<ForkGeneration>(GetParam()));
  const auto now = [&] { return static_cast<std::uint8_t>(generation.current()); };
  const auto own = now();
  EXPECT_EQ(now(), own);
  const auto line = from_child([&] {
    const auto childs = now();
    const auto grandchilds = from_child([&] { return Bytes{now()}; });
    return Bytes{childs, now(), grandchilds.at(0)};
  });
  ASSERT_EQ(line.size(), 3u);
  EXPECT_NE(line[0], own);
  EXPECT_EQ(line[1], line[0]);
  EXPECT_NE(line[2], line[0]);
  EXPECT_NE(line[2], own);
  EXPECT_EQ(now(), own);
}

TEST(ForkedSender, ChallengesAndKeysDrawnByParentAndChild_Differ) {
  SystemRandom random;
  const auto draw = [&] {
    Bytes out(32);
    EXPECT_TRUE(random.fill(out));
    return out;
  };
  static_cast<void>(draw());
  const auto of_child = from_child(draw);
  EXPECT_EQ(of_child.size(), 32u);
  EXPECT_NE(of_child, draw());
}

}  // namespace
}  // namespace ddssec::cryptography::testing
