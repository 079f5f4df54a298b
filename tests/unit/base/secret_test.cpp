#include "base/secret.hpp"

#include <new>

#include <gtest/gtest.h>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "base/seeded_random.hpp"

namespace ddssec {
namespace {

using Key = Secret<struct KeyTag, 32>;

Key key_of(std::string_view text) { return Key::copy_of(as_bytes(text)).value(); }

TEST(Secret, Destruction_WipesIt) {
  alignas(Key) std::array<std::uint8_t, sizeof(Key)> place{};
  auto* key = new (place.data()) Key(key_of("0123456789abcdef"));
  key->~Key();
  EXPECT_EQ(as_text(place).find("0123"), std::string_view::npos);
}

TEST(Secret, Moving_WipesTheSource) {
  Key from = key_of("0123456789abcdef");
  const Key to = std::move(from);
  EXPECT_TRUE(from.empty());  // NOLINT(bugprone-use-after-move): this is what is tested
  EXPECT_EQ(as_text(BytesView(reinterpret_cast<const std::uint8_t*>(&from), 32)).find("0123"),
            std::string_view::npos);
  EXPECT_EQ(to.size(), 16u);
}

TEST(Secret, SizeAndOctets_AreCompared) {
  EXPECT_EQ(key_of("abc"), key_of("abc"));
  EXPECT_FALSE(key_of("abc") == key_of("abd"));
  EXPECT_FALSE(key_of("abc") == key_of(std::string_view("abc\0", 4)));
}

TEST(Secret, MoreThanItHolds_IsRefused) {
  EXPECT_EQ(Key::copy_of(Bytes(33)).error().code(), Code::length_out_of_range);
}

TEST(Hash, KnownTexts_GiveKnownAnswers) {
  EXPECT_EQ(to_hex(sha256(as_bytes("abc"))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256({as_bytes("a"), as_bytes("bc")}), sha256(as_bytes("abc")));
  EXPECT_EQ(to_hex(hmac_sha256(as_bytes("Jefe"),
                               {as_bytes("what do ya want "), as_bytes("for nothing?")})),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(to_hex(md5(as_bytes("abc"))), "900150983cd24fb0d6963f7d28e17f72");
}

TEST(Random, SystemSource_DiffersAndTheSeededRepeats) {
  std::array<std::uint8_t, 32> a{}, b{};
  SystemRandom system;
  ASSERT_TRUE(system.fill(a));
  ASSERT_TRUE(system.fill(b));
  EXPECT_NE(a, b);
  SeededRandom one(1), again(1), two(2);
  ASSERT_TRUE(one.fill(a));
  ASSERT_TRUE(again.fill(b));
  EXPECT_EQ(a, b);
  ASSERT_TRUE(two.fill(b));
  EXPECT_NE(a, b);
}

TEST(Clock, AManualClock_MovesByParts) {
  ManualClock clock{WallTime(std::chrono::seconds(10))};
  clock.advance(std::chrono::milliseconds(600));
  EXPECT_EQ(clock.now(), WallTime(std::chrono::seconds(10)));
  EXPECT_EQ(clock.wall(), std::chrono::milliseconds(10'600));
  clock.advance(std::chrono::milliseconds(600));
  EXPECT_EQ(clock.now(), WallTime(std::chrono::seconds(11)));
  EXPECT_EQ(clock.wall(), std::chrono::milliseconds(11'200));
  EXPECT_EQ(clock.monotonic(), std::chrono::milliseconds(1'200));
}

TEST(Clock, Time_IsWrittenAsInTheDocuments) {
  EXPECT_EQ(to_string(WallTime{std::chrono::seconds(0)}), "1970-01-01T00:00:00Z");
}

}  // namespace
}  // namespace ddssec
