// A domain whose bootstrapping messages are protected by a pre-shared key (T62 in docs/attacks.md):
// which participants join, and what others see.
#include "rtps/security/pre_shared_messages.hpp"

#include <random>

#include "plugins/spi/files_poll_interval.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr Rules kHidden{.rtps_psk = kEncrypt};

spi::PropertyList phrase(std::string_view text, std::string_view extra = {}) {
  spi::PropertyList out = {{std::string(spi::property::kPskPassphrase), data_uri(text), false}};
  if (!extra.empty())
    out.push_back({std::string(spi::property::kPskExtraPassphrases), data_uri(extra), false});
  return out;
}

constexpr std::string_view kText = "5632:castle super radar denial";
const spi::PropertyList kPhrase = phrase(kText);

struct Domain : Pair {
  explicit Domain(const Rules& rules, const spi::PropertyList& of_a = kPhrase,
                  const spi::PropertyList& of_b = kPhrase)
      : Pair(rules, rules, of_a, of_b) {}
  Domain(const Rules& of_a, const Rules& of_b, const spi::PropertyList& more_of_a,
         const spi::PropertyList& more_of_b)
      : Pair(of_a, of_b, more_of_a, more_of_b) {}
  // Matches and passes a sample.
  bool talk() {
    if (!match()) return false;
    write();
    return world.run_until([&] { return b.listener.changes.size() == 1; }, 200);
  }
};

// Returns the keys of a participant that knows that passphrase.
std::unique_ptr<spi::PreSharedKeys> keys_of(Node& node, std::string_view text) {
  return node.cryptography->key_factory()
      .pre_shared_keys({phrase(text), {.rtps_psk = kEncrypt}, 0, ""})
      .value();
}

// Protects a message as any participant in the domain of `of` could.
Bytes sealed(BytesView plain, Node& of) {
  auto keys = keys_of(of, kText);
  Bytes out(plain.size() + spi::protection_overhead(0));
  out.resize(keys->encode(plain, out).value());
  return out;
}

// Records everything that is sent, without the passphrase.
struct Recorder {
  explicit Recorder(World& world) {
    world.filter = [this](const Node&, Bytes datagram) {
      heard.push_back(datagram);
      return one(std::move(datagram));
    };
  }
  std::size_t count(bool by_pre_shared_key) const {
    return static_cast<std::size_t>(std::ranges::count_if(heard, [&](const auto& datagram) {
      return spi::has_pre_shared_key_flag(datagram) == by_pre_shared_key;
    }));
  }
  std::vector<std::string> seen_of(std::initializer_list<std::string_view> words) const {
    std::vector<std::string> out;
    for (const auto word : words)
      if (std::ranges::any_of(heard, [&](const auto& datagram) {
            return as_text(datagram).find(word) != std::string_view::npos;
          }))
        out.emplace_back(word);
    return out;
  }
  std::vector<Bytes> heard;
};

TEST(PreSharedKey, ARecorderWithoutIt_SeesNeitherIdentityNorPermissionsNorTopic) {
  const auto words = {std::string_view("alice"),
                      std::string_view("Identity CA"),
                      std::string_view("BEGIN CERTIFICATE"),
                      std::string_view("<permissions>"),
                      std::string_view("DDS:Auth:PKI-DH"),
                      std::string_view("dds.sec."),
                      std::string_view("Square"),
                      std::string_view("ShapeType")};
  Domain hidden(kHidden);
  const Recorder recorder(hidden.world);
  ASSERT_TRUE(hidden.talk()) << hidden.a.events.text() << hidden.b.events.text();
  EXPECT_THAT(recorder.seen_of(words), ::testing::IsEmpty());
  EXPECT_EQ(recorder.count(false), 0u);
  EXPECT_GT(recorder.count(true), 10u);
  // Without the key, everything can be seen.
  Domain open(Rules{}, {}, {});
  const Recorder of_open(open.world);
  ASSERT_TRUE(open.talk());
  EXPECT_EQ(of_open.seen_of(words).size(), words.size());
  EXPECT_EQ(of_open.count(true), 0u);
}

TEST(PreSharedKey, ParticipantsKeys_ProtectWhatIsTheirsAndThePreSharedKeyTheRest) {
  for (const auto psk : {kSign, kEncrypt})
    for (const auto kind : {kSign, kEncrypt}) {
      auto rules = everything(kind);
      rules.rtps_psk = psk;
      Domain domain(rules);
      const Recorder recorder(domain.world);
      ASSERT_TRUE(domain.talk()) << domain.a.events.text() << domain.b.events.text();
      EXPECT_GT(recorder.count(true), 10u);
      EXPECT_GT(recorder.count(false), 10u);
      for (const auto& datagram : recorder.heard)
        EXPECT_EQ(datagram.at(20), 0x33) << "a message that nothing protects";
      EXPECT_EQ(domain.b->protection_counters().unprotected, 0u);
      EXPECT_EQ(recorder.seen_of({"<permissions>"}).empty(), psk == kEncrypt);
    }
}

TEST(PreSharedKey, MemberWithAnotherPassphraseOrId_IsNotHeard) {
  const auto refusal = [](const spi::PropertyList& of_b) {
    Domain domain(kHidden, kPhrase, of_b);
    domain.create_endpoints();
    domain.world.run(300);
    EXPECT_EQ(domain.a->remote_participants().size() + domain.b->remote_participants().size(), 0u);
    EXPECT_GT(domain.a->protection_counters().undecodable, 3u);
    EXPECT_EQ(domain.a.events.text().find("castle"), std::string::npos);
    return domain.a.events.all.empty() ? Code{} : domain.a.events.all.front().error.code();
  };
  EXPECT_EQ(refusal(phrase("5632:castle super radar denial!")), Code::tag_mismatch);
  EXPECT_EQ(refusal(phrase("5633:castle super radar denial")), Code::psk_passphrase_unknown);
}

TEST(PreSharedKey, ParticipantWithoutIt_IsRefusedWithTheReasonOnBothSides) {
  Domain domain(kHidden, Rules{}, kPhrase, {});
  domain.create_endpoints();
  domain.world.run(300);
  EXPECT_EQ(domain.a->remote_participants().size() + domain.b->remote_participants().size(), 0u);
  EXPECT_TRUE(domain.a.events.has(Code::rtps_protection_missing));
  EXPECT_TRUE(domain.b.events.has(Code::secure_flags_unsupported));
  EXPECT_GT(domain.a->protection_counters().unprotected, 3u);
  EXPECT_GT(domain.b->protection_counters().undecodable, 3u);
}

TEST(PreSharedKey, AVendorThatCannot_IsNamed) {
  Domain domain(kHidden);
  auto datagram = announcement(secured_data(fake_prefix(1)));
  std::ranges::copy(kVendorCyclone.octets, datagram.begin() + 6);
  domain.a->receive(datagram, domain.world.now);
  ASSERT_TRUE(domain.a.events.has(Code::rtps_protection_missing));
  EXPECT_NE(domain.a.events.text().find("of Cyclone DDS"), std::string::npos);
  EXPECT_EQ(domain.a->remote_participants().size(), 0u);
}

TEST(PreSharedKey, SignedAndEncrypted_DoNotMeet) {
  Domain domain(kHidden, Rules{.rtps_psk = kSign}, kPhrase, kPhrase);
  domain.world.run(200);
  EXPECT_EQ(domain.a->remote_participants().size() + domain.b->remote_participants().size(), 0u);
  EXPECT_TRUE(domain.a.events.has(Code::signed_where_encryption_is_due));
  EXPECT_TRUE(domain.b.events.has(Code::encrypted_where_signature_is_due));
}

TEST(PreSharedKey, AnnouncementWithoutIt_IsAMismatch) {
  Domain domain(kHidden);
  // A participant with the passphrase and another governance announces no such protection.
  domain.a->receive(sealed(announcement(secured_data(fake_prefix(1))), domain.b), domain.world.now);
  EXPECT_TRUE(domain.a.events.has(Code::rtps_security_info_mismatch)) << domain.a.events.text();
}

TEST(PreSharedKey, APassphrase_IsChangedInARunningDomain) {
  const auto before = phrase("1:old passphrase", "2:new passphrase");
  const auto between = phrase("2:new passphrase", "1:old passphrase");
  const auto after = phrase("2:new passphrase");
  EXPECT_TRUE(Domain(kHidden, before, between).talk());
  EXPECT_TRUE(Domain(kHidden, between, after).talk());
  EXPECT_TRUE(Domain(kHidden, phrase("1:old passphrase"), before).talk());
  Domain apart(kHidden, phrase("1:old passphrase"), after);
  apart.world.run(200);
  EXPECT_TRUE(apart.b.events.has(Code::psk_passphrase_unknown));
  EXPECT_EQ(apart.b->remote_participants().size(), 0u);
}

// The writer never pauses, and each participant looks at its files at its own time.
TEST(PreSharedKey, ChangeWhileParticipantsTalk_LosesNothing) {
  constexpr std::string_view kOld = "1:old passphrase", kNew = "2:new passphrase";
  const test::TemporaryFolder of_a, of_b;
  const auto put = [&](const std::string& name, std::string_view text) {
    for (const auto* folder : {&of_a, &of_b}) folder->replace(name, text);
  };
  const auto files = [](const test::TemporaryFolder& folder) {
    return spi::PropertyList{
        {std::string(spi::property::kPskPassphrase), "file:" + folder.path() + "/own", false},
        {std::string(spi::property::kPskExtraPassphrases), "file:" + folder.path() + "/extra",
         false}};
  };
  put("own", kOld);
  put("extra", kOld);
  Domain domain(kHidden, files(of_a), files(of_b));
  ASSERT_TRUE(domain.match()) << domain.a.events.text() << domain.b.events.text();
  const auto recorder = keys_of(domain.a, kOld);
  int seen = 0, read = 0;
  domain.world.filter = [&](const Node&, Bytes datagram) {
    Bytes plain(datagram.size());
    ++seen;
    read += recorder->decode(datagram, plain) ? 1 : 0;
    return one(std::move(datagram));
  };
  std::size_t written = 0;
  // One participant looks after the other, so they differ by one step until the second one has
  // looked.
  const auto both_look = [&](int changes) {
    for (auto* node : {&domain.a, &domain.b}) {
      for (int i = 0; i < 120; ++i, ++written) {
        node->clock.advance(100ms);
        domain.write();
        domain.world.run(1);
      }
      EXPECT_EQ(node->events.count(Code::psk_passphrases_changed), changes) << node->events.text();
    }
  };
  both_look(0);
  EXPECT_EQ(read, seen);
  put("extra", std::string(kOld) + "\n" + std::string(kNew) + "\n");
  both_look(1);
  EXPECT_EQ(read, seen);
  put("own", kNew);
  both_look(2);
  EXPECT_LT(read, seen);
  put("extra", kNew);
  both_look(3);
  seen = read = 0;
  both_look(3);
  EXPECT_TRUE(domain.world.run_until([&] { return domain.b.listener.changes.size() == written; }))
      << domain.b.listener.changes.size() << " of " << written;
  EXPECT_EQ(domain.b->protection_counters().undecodable, 0u) << domain.b.events.text();
  EXPECT_GT(seen, 200);
  EXPECT_EQ(read, 0) << "by who knows the old passphrase alone";
}

TEST(PreSharedKey, ChangedOrCutOffMessages_AreNotHeard) {
  Domain domain(kHidden);
  const Recorder recorder(domain.world);
  ASSERT_TRUE(domain.talk());
  const auto& genuine = recorder.heard.front();
  const auto before = domain.b->protection_counters();
  const auto malformed = domain.b->counters().malformed;
  std::uint64_t sent = 0;
  for (std::size_t size = 0; size < genuine.size(); ++size, ++sent)
    domain.b->receive(BytesView(genuine).first(size), domain.world.now);
  for (std::size_t at = 0; at < genuine.size(); ++at, ++sent) {
    auto changed = genuine;
    changed[at] ^= 0x10;
    domain.b->receive(changed, domain.world.now);
  }
  const auto after = domain.b->protection_counters();
  EXPECT_EQ(after.undecodable - before.undecodable + after.unprotected - before.unprotected +
                domain.b->counters().malformed - malformed,
            sent);
  EXPECT_EQ(domain.b->remote_participants().size(), 1u);
}

// 20,000 messages a second name the right key, under ever new names and under that of the honest
// peer. The work is bounded, and the honest peer joins.
TEST(PreSharedKey, AFloodOfForgedMessages_CostsLittleAndKeepsNoMemberOut) {
  Domain domain(kHidden);
  auto forged = sealed(announcement(secured_data(fake_prefix(1))), domain.b);
  forged[forged.size() - 10] ^= 1;
  std::mt19937 random(7);
  std::uint32_t number = 0;
  domain.world.attack = [&](World::Traffic& traffic) {
    for (int i = 0; i < 200; ++i) {
      const auto name = i % 10 == 0 ? domain.a->prefix() : fake_prefix(++number);
      std::ranges::copy(name.octets, forged.begin() + 8);
      traffic.emplace_back(domain.b.port, forged);
    }
    std::ranges::shuffle(traffic, random);
  };
  domain.world.nodes = {&domain.b};
  domain.world.run(50);
  domain.world.nodes = {&domain.a, &domain.b};
  const auto since = domain.world.now;
  EXPECT_TRUE(domain.match());
  EXPECT_LT(domain.world.now - since, 2s);
  EXPECT_EQ(domain.b->remote_participants().size(), 1u);
  EXPECT_LT(domain.b.events.all.size(), 100u);
}

}  // namespace
}  // namespace ddssec::rtps
