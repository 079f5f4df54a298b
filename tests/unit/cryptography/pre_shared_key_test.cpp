// Messages under a domain's pre-shared key: which participants can open them, and which cannot.
#include "plugins/cryptography/pre_shared_key.hpp"

#include <set>
#include <sys/stat.h>

#include <gmock/gmock.h>

#include "plugins/spi/files_poll_interval.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/cryptography/passphrases.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;

// The keys of one participant, in a plugin of its own.
struct Member {
  explicit Member(const PropertyList& properties, ProtectionKind kind = kEncrypt,
                  DomainId domain = 7, std::string_view tag = "",
                  const CryptographyOptions& options = {})
      : side(options) {
    ParticipantSecurityAttributes attributes;
    attributes.rtps_psk = kind;
    auto made = side.factory().pre_shared_keys({properties, attributes, domain, tag});
    EXPECT_TRUE(made) << made.error().to_sentence();
    if (made) keys = std::move(*made);
  }
  Bytes encode(BytesView plain) {
    return into_bytes(plain.size() + spi::protection_overhead(0),
                      [&](MutableBytes out) { return keys->encode(plain, out); })
        .value();
  }
  Result<Bytes> decode(BytesView encoded) {
    return into_bytes(encoded.size(), [&](MutableBytes out) { return keys->decode(encoded, out); });
  }
  Side side;
  std::unique_ptr<spi::PreSharedKeys> keys;
};

Bytes hello() { return rtps_message({data_submessage(12), data_submessage(8)}); }
// Returns a message in the name of the `i`-th participant.
Bytes hello_from(std::uint32_t i) {
  auto out = hello();
  for (std::size_t octet = 0; octet < 4; ++octet)
    out[8 + octet] = static_cast<std::uint8_t>(i >> (8 * octet));
  return out;
}
// Returns the message as it is decoded, with an INFO_SRC that repeats the header at its beginning.
Bytes with_source(const Bytes& plain) {
  Bytes out(plain.begin(), plain.begin() + 20);
  for (std::uint8_t octet : {0x0c, 0x01, 20, 0, 0, 0, 0, 0}) out.push_back(octet);
  out.insert(out.end(), plain.begin() + 4, plain.end());
  return out;
}

TEST(PreSharedKeyMessages, EveryCipher_OpensWithTheSamePassphraseAndNoOther) {
  for (const auto kind : {kSign, kEncrypt})
    for (const auto cipher : {spi::kAes128Name, spi::kAes256Name, spi::kChaCha20Poly1305Name}) {
      Member a(passphrase("5612:Open Sesame", {}, cipher), kind);
      Member b(passphrase("5612:Open Sesame", {}, cipher), kind);
      Member c(passphrase("5612:Open sesame", {}, cipher), kind);
      const auto encoded = a.encode(hello());
      EXPECT_TRUE(spi::has_pre_shared_key_flag(encoded));
      EXPECT_EQ(b.decode(encoded), with_source(hello()));
      EXPECT_EQ(code_of(c.decode(encoded)), Code::tag_mismatch);
      const auto clear = std::ranges::search(encoded, data_submessage(12));
      EXPECT_EQ(clear.empty(), kind == kEncrypt);
    }
}

TEST(PreSharedKeyMessages, AnotherIdDomainOrTag_IsAnotherKey) {
  Member a(passphrase("5612:Open Sesame"));
  const auto encoded = a.encode(hello());
  const auto refusal = [&](Member other) { return code_of(other.decode(encoded)); };
  EXPECT_EQ(refusal(Member(passphrase("5613:Open Sesame"))), Code::psk_passphrase_unknown);
  // The low octet, which is the key id, is the same. The other octets are the key revision.
  EXPECT_EQ(refusal(Member(passphrase("5868:Open Sesame"))), Code::psk_passphrase_unknown);
  EXPECT_EQ(refusal(Member(passphrase("5612:Open Sesame"), kEncrypt, 8)),
            Code::psk_passphrase_unknown);
  EXPECT_EQ(refusal(Member(passphrase("5612:Open Sesame"), kEncrypt, 7, "yard")),
            Code::psk_passphrase_unknown);
}

TEST(PreSharedKeyMessages, ProtectionAndCipher_MustBeOurs) {
  const auto same = passphrase("1:Open Sesame");
  EXPECT_EQ(code_of(Member(same, kSign).decode(Member(same).encode(hello()))),
            Code::encrypted_where_signature_is_due);
  EXPECT_EQ(code_of(Member(same).decode(Member(same, kSign).encode(hello()))),
            Code::signed_where_encryption_is_due);
  Member weak(passphrase("1:Open Sesame", {}, spi::kAes128Name));
  EXPECT_EQ(code_of(Member(same).decode(weak.encode(hello()))), Code::transform_kind_mismatch);
}

TEST(PreSharedKeyMessages, ChangedOrCutOffMessages_AreNotOpened) {
  const auto is_refusal =
      ::testing::AnyOf(Code::not_protected, Code::secure_group_malformed,
                       Code::secure_flags_unsupported, Code::crypto_header_kind_unknown,
                       Code::transform_kind_mismatch, Code::transform_key_id_mismatch,
                       Code::unknown_key_id, Code::psk_passphrase_unknown, Code::tag_mismatch);
  for (const auto kind : {kSign, kEncrypt}) {
    Member a(passphrase("5632:Open Sesame"), kind), b(passphrase("5632:Open Sesame"), kind);
    const auto genuine = a.encode(hello());
    for (int round = 0; round < 2; ++round) {  // first from a stranger, then from a known sender
      for (std::size_t size = 0; size < genuine.size(); ++size)
        EXPECT_THAT(code_of(b.decode(BytesView(genuine).first(size))), is_refusal) << size;
      for (std::size_t bit = 0; bit < 8 * genuine.size(); ++bit) {
        auto changed = genuine;
        changed[bit / 8] ^= static_cast<std::uint8_t>(1 << (bit % 8));
        EXPECT_THAT(code_of(b.decode(changed)), is_refusal) << "bit " << bit;
      }
      EXPECT_TRUE(b.decode(genuine));
    }
  }
}

TEST(PreSharedKeyMessages, WhatIsNoMessage_IsNotEncodedAndNoSmallBufferIsOverrun) {
  Member a(passphrase("1:Open Sesame")), b(passphrase("1:Open Sesame"));
  const auto plain = hello();
  const auto encoded = a.encode(plain);
  Bytes out(encoded.size());
  for (std::size_t size = 0; size < encoded.size(); ++size)
    EXPECT_EQ(code_of(a.keys->encode(plain, MutableBytes(out).first(size))),
              Code::length_out_of_range);
  EXPECT_EQ(code_of(a.keys->encode(BytesView(plain).first(19), out)), Code::plaintext_malformed);
  EXPECT_EQ(code_of(a.keys->encode(BytesView(plain).first(20), out)), Code::plaintext_malformed);
  auto other = plain;
  other[0] = 'X';
  EXPECT_EQ(code_of(a.keys->encode(other, out)), Code::plaintext_malformed);
  for (std::size_t size = 0; size < plain.size() + 24; ++size)
    EXPECT_EQ(code_of(b.keys->decode(encoded, MutableBytes(out).first(size))),
              Code::length_out_of_range);
}

TEST(PreSharedKeyMessages, APassphrase_IsChangedWithoutLosingAMessage) {
  Member before(passphrase("1:old passphrase", "2:new passphrase"));
  Member between(passphrase("2:new passphrase", "1:old passphrase"));
  Member after(passphrase("2:new passphrase"));
  Member old_only(passphrase("1:old passphrase"));
  EXPECT_TRUE(between.decode(before.encode(hello_from(1))));
  EXPECT_TRUE(before.decode(between.encode(hello_from(2))));
  EXPECT_TRUE(after.decode(between.encode(hello_from(2))));
  EXPECT_TRUE(before.decode(after.encode(hello_from(3))));
  EXPECT_TRUE(old_only.decode(before.encode(hello_from(1))));
  EXPECT_EQ(code_of(after.decode(before.encode(hello_from(1)))), Code::psk_passphrase_unknown);
  EXPECT_EQ(code_of(old_only.decode(after.encode(hello_from(3)))), Code::psk_passphrase_unknown);
  // Two messages in the same name, one under each passphrase.
  EXPECT_TRUE(between.decode(old_only.encode(hello_from(4))));
  EXPECT_TRUE(between.decode(after.encode(hello_from(4))));
}

TEST(PreSharedKeyMessages, OnlyMembersMessages_AreRememberedAndOnlySoMany) {
  Member a(passphrase("1:Open Sesame")), b(passphrase("1:Open Sesame"));
  auto& ring = dynamic_cast<PreSharedKeyRing&>(*b.keys);
  const auto first = a.encode(hello_from(0));
  EXPECT_FALSE(ring.remembers(first));
  auto forged = first;
  forged[60] ^= 1;
  EXPECT_EQ(code_of(b.decode(forged)), Code::tag_mismatch);
  EXPECT_FALSE(ring.remembers(first));
  EXPECT_TRUE(b.decode(first));
  EXPECT_TRUE(ring.remembers(first));
  EXPECT_FALSE(ring.remembers(Bytes(first.begin(), first.begin() + 30)));
  constexpr auto kMax = static_cast<std::uint32_t>(PreSharedKeyRing::kMaxSenders);
  for (std::uint32_t i = 1; i <= kMax; ++i) {
    EXPECT_TRUE(b.decode(first));  // this sender is heard again and again
    EXPECT_TRUE(b.decode(a.encode(hello_from(i))));
  }
  std::uint32_t remembered = 0;
  for (std::uint32_t i = 0; i <= kMax; ++i)
    remembered += ring.remembers(a.encode(hello_from(i))) ? 1 : 0;
  EXPECT_EQ(remembered, kMax);
  EXPECT_TRUE(ring.remembers(first));
  EXPECT_FALSE(ring.remembers(a.encode(hello_from(1))));
  EXPECT_TRUE(b.decode(a.encode(hello_from(1))));
}

TEST(PreSharedKeyMessages, RestartOrNewSession_RepeatsNoIv) {
  const auto iv = [](const Bytes& message) {
    return std::string(message.begin() + 32, message.begin() + 44);
  };
  std::set<std::string> seen;
  for (int restart = 0; restart < 4; ++restart) {
    Member a(passphrase("1:Open Sesame"), kEncrypt, 7, "", {.max_blocks_per_session = 20});
    Member b(passphrase("1:Open Sesame"));
    for (int i = 0; i < 10; ++i) {
      const auto encoded = a.encode(hello());
      EXPECT_TRUE(b.decode(encoded));
      EXPECT_TRUE(seen.insert(iv(encoded)).second);
    }
  }
}

TEST(PreSharedKeyMessages, DifferentSourcesInsideAndOutside_AreRefused) {
  Member b(passphrase("1:Open Sesame"));
  // A participant that knows the passphrase can make such a message, under the key of the outer
  // name.
  const auto source = [](const Bytes& message) {
    MessageSource out;
    std::copy_n(message.begin() + 4, 16, out.begin());
    return out;
  };
  const Passphrase phrase{1, Passphrase::Text::copy_of(as_bytes("Open Sesame")).value()};
  const auto kind = pre_shared_kind(kAes256Gcm, 1);
  RetiredObjects retired_objects;
  SystemRandom random;
  const KeyServices services{*aead_backend(AeadChoice::openssl), retired_objects, 1000, 1000,
                             random};
  auto key = SendKey::create(derive_pre_shared_material(phrase, kind, pre_shared_key_id(1, 7, ""),
                                                        source(hello_from(5))),
                             {1, 1}, services)
                 .value();
  const auto plain = hello_from(6);
  auto encoded = into_bytes(plain.size() + 112, [&](MutableBytes out) {
                   const ReadGuard guard;
                   return seal_message(plain, kPreSharedKeyFrame, *key, out);
                 }).value();
  std::copy_n(hello_from(5).begin(), 20, encoded.begin());
  EXPECT_EQ(code_of(b.decode(encoded)), Code::info_source_mismatch);
  EXPECT_FALSE(b.keys->remembers(encoded));
}

TEST(PreSharedKeyMessages, WhatTheGovernanceDoesNotAskForOrAllow_IsNotMade) {
  Side side;
  const auto made = [&](const PropertyList& properties, ProtectionKind kind,
                        spi::CipherMask allowed = spi::kAllCiphers) {
    ParticipantSecurityAttributes attributes;
    attributes.rtps_psk = kind;
    attributes.allowed_ciphers = allowed;
    return code_of(side.factory().pre_shared_keys({properties, attributes, 0, ""}));
  };
  const auto good = passphrase("1:Open Sesame");
  EXPECT_EQ(made(good, kEncrypt), Code{0});
  EXPECT_EQ(made(good, ProtectionKind::none), Code::not_protected);
  EXPECT_EQ(made(good, kEncrypt, spi::kAes128Bit), Code::cipher_not_allowed);
  EXPECT_EQ(made(passphrase("1:Open Sesame", {}, "AUTO"), kEncrypt), Code{0});
  EXPECT_EQ(made(passphrase("1:Open Sesame", {}, "DES"), kEncrypt), Code::invalid_property);
  EXPECT_EQ(made({}, kEncrypt), Code::missing_property);
  EXPECT_EQ(made({{std::string(property::kPskExtraPassphrases), "data:,1:Open Sesame"}}, kEncrypt),
            Code::missing_property);
}

// ---- passphrases that change while the participant runs

// A member whose passphrases are in files.
struct Running {
  explicit Running(std::string_view first, const PropertyList& more = {})
      : member((put("own", first), put("extra", first), properties(more))) {}
  PropertyList properties(PropertyList more) const {
    more.push_back({std::string(property::kPskPassphrase), "file:" + folder.path() + "/own"});
    more.push_back(
        {std::string(property::kPskExtraPassphrases), "file:" + folder.path() + "/extra"});
    return more;
  }
  void put(const std::string& name, std::string_view text) const {
    ::chmod(folder.replace(name, text).c_str(), 0600);
  }
  // Returns the codes of the events that are raised within this time.
  std::vector<Code> after(std::chrono::seconds time = spi::kDefaultFilesPollInterval) {
    member.side.events.all.clear();
    member.side.clock.advance(time);
    member.keys->refresh();
    return member.side.events.codes();
  }
  std::string said() const { return member.side.events.last(); }

  test::TemporaryFolder folder;
  Member member;
};

constexpr auto kChanged = Code::psk_passphrases_changed;
constexpr auto kKept = Code::psk_passphrases_kept;
using Codes = std::vector<Code>;

TEST(ChangedPassphrases, NewPassphrase_IsUsedStepByStepWithoutAGap) {
  Running running("1:old");
  Member old(passphrase("1:old")), fresh(passphrase("2:new"));
  const auto understands = [&](Member& other, std::uint32_t name) {
    return bool(running.member.decode(other.encode(hello_from(name))));
  };
  EXPECT_EQ(running.after(), Codes{});
  EXPECT_TRUE(understands(old, 1));
  EXPECT_FALSE(understands(fresh, 2));
  running.put("extra", "1:old\n2:new\n");
  EXPECT_EQ(running.after(), Codes{kChanged});
  EXPECT_NE(running.said().find("1 to send with, understood are 1, 2"), std::string::npos);
  EXPECT_TRUE(old.decode(running.member.encode(hello())));
  EXPECT_TRUE(understands(old, 1));
  EXPECT_TRUE(understands(fresh, 1));
  running.put("own", "2:new");
  EXPECT_EQ(running.after(), Codes{kChanged});
  EXPECT_EQ(code_of(old.decode(running.member.encode(hello()))), Code::psk_passphrase_unknown);
  EXPECT_TRUE(fresh.decode(running.member.encode(hello())));
  EXPECT_TRUE(understands(old, 1));
  EXPECT_TRUE(understands(fresh, 1));
  running.put("extra", "2:new");
  EXPECT_EQ(running.after(), Codes{kChanged});
  EXPECT_FALSE(running.member.keys->remembers(old.encode(hello_from(1))));
  EXPECT_TRUE(running.member.keys->remembers(fresh.encode(hello_from(1))));
  EXPECT_FALSE(understands(old, 1));
  EXPECT_TRUE(understands(fresh, 1));
  EXPECT_EQ(running.after(), Codes{});
}

TEST(ChangedPassphrases, SameId_ReplacesThePassphrase) {
  Running running("1:odl");
  Member old(passphrase("1:odl")), fresh(passphrase("1:old"));
  EXPECT_TRUE(running.member.decode(old.encode(hello())));
  EXPECT_TRUE(old.decode(running.member.encode(hello())));
  running.put("own", "1:old");
  EXPECT_EQ(running.after(), Codes{kKept}) << "one id for two passphrases";
  running.put("extra", "1:old");
  EXPECT_EQ(running.after(), Codes{kChanged});
  EXPECT_FALSE(running.member.keys->remembers(old.encode(hello())));
  EXPECT_TRUE(running.member.decode(fresh.encode(hello())));
  EXPECT_TRUE(fresh.decode(running.member.encode(hello())));
}

TEST(ChangedPassphrases, UnusablePassphrases_ChangeNothingAndAreReportedOnce) {
  Running running("1:old");
  Member old(passphrase("1:old"));
  const auto path = running.folder.path() + "/own";
  const auto refused = [&](std::string_view why) {
    EXPECT_EQ(running.after(), Codes{kKept}) << why;
    EXPECT_TRUE(running.said().starts_with(path)) << running.said();
    EXPECT_NE(running.said().find(why), std::string::npos) << running.said();
    EXPECT_EQ(running.said().find("xyzzy"), std::string::npos) << running.said();
    for (int again = 0; again < 3; ++again) EXPECT_EQ(running.after(), Codes{}) << why;
    EXPECT_TRUE(running.member.decode(old.encode(hello())));
    EXPECT_TRUE(old.decode(running.member.encode(hello())));
  };
  running.put("own", "2xyzzy");
  refused("ID:PASSPHRASE");
  running.put("own", "255:xyzzy");
  refused("255");
  running.put("own", "2:xyzzy\n3:xyzzy\n");
  refused("at most 1 line");
  running.put("own", "");
  refused("empty");
  running.put("own", "1:xyzzy");
  EXPECT_EQ(running.after(), Codes{kKept});
  EXPECT_TRUE(running.said().starts_with(running.folder.path() + "/extra")) << running.said();
  std::filesystem::remove(path);
  refused("not");
  std::filesystem::create_directory(path);
  refused("regular file");
  std::filesystem::remove(path);
  running.put("own", "1:old");
  EXPECT_EQ(running.after(), Codes{}) << "as it was";
  running.put("own", "2:new");
  EXPECT_EQ(running.after(), Codes{kChanged});
  running.put("own", "2xyzzy");
  EXPECT_EQ(running.after(), Codes{kKept}) << "told once more, since it was good meanwhile";
}

TEST(ChangedPassphrases, PollInterval_DecidesHowOftenTheyAreLookedFor) {
  const auto every = [](std::string seconds) {
    return PropertyList{{std::string(property::kFilesPollInterval), std::move(seconds)}};
  };
  Running seldom("1:old", every("60")), never("1:old", every("0"));
  EXPECT_EQ(seldom.after(), Codes{});  // this is the first look
  for (auto* running : {&seldom, &never}) {
    running->put("extra", "1:old\n2:new");
    EXPECT_EQ(running->after(std::chrono::seconds(59)), Codes{});
  }
  EXPECT_EQ(seldom.after(std::chrono::seconds(1)), Codes{kChanged});
  EXPECT_EQ(never.after(std::chrono::hours(24)), Codes{});
  auto bad = every("often");
  bad.push_back({std::string(property::kPskPassphrase), "data:,1:old"});
  ParticipantSecurityAttributes attributes;
  attributes.rtps_psk = kEncrypt;
  EXPECT_EQ(code_of(Side().factory().pre_shared_keys({bad, attributes, 0, ""})),
            Code::invalid_property);
}

TEST(ChangedPassphrases, DataUris_NeverChange) {
  Member member(passphrase("1:old", "2:new"));
  member.side.clock.advance(std::chrono::hours(1));
  member.keys->refresh();
  EXPECT_EQ(member.side.events.codes(), Codes{});
  EXPECT_TRUE(Member(passphrase("1:old")).decode(member.encode(hello())));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
