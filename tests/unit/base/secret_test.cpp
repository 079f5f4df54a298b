#include "base/secret.hpp"

#include <new>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace ddssec
