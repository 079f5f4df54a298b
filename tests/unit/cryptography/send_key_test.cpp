// The numbers of one sending key: none is used twice, and a session ends in time.
#include "plugins/cryptography/send_key.hpp"

#include <gtest/gtest.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/cryptography/sample_key_material.hpp"

namespace ddssec::cryptography::testing {
namespace {

using test::code_of;

// A key whose sessions have 10 blocks. After three sessions it is used up.
struct SendKeyTest : ::testing::Test {
  std::unique_ptr<SendKey> made(SendStart start = {.session = 1, .suffix = 100}) {
    return SendKey::create(material(kAes256Gcm), start, services).value();
  }

  SystemRandom random;
  RetiredObjects retired_objects;
  const KeyServices services{*aead_backend(AeadChoice::automatic), retired_objects, 10, 3, random};
};

TEST_F(SendKeyTest, TwoMessages_HaveDifferentIvsOfOneSession) {
  const auto key = made();
  const ReadGuard guard;
  const auto first = key->reserve(16);
  const auto second = key->reserve(16);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->session->id, second->session->id);
  EXPECT_NE(first->iv, second->iv);
  EXPECT_EQ(key->blocks_used(), 6u) << "three for each: the tag and the mask of it count";
}

TEST_F(SendKeyTest, SessionWithoutEnoughBlocks_GivesWayToTheNext) {
  const auto key = made();
  const ReadGuard guard;
  const auto first = key->reserve(64);
  const auto second = key->reserve(64);
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->session->id, second->session->id);
  EXPECT_TRUE(key->has_begun(first->session->id));
  EXPECT_TRUE(key->has_begun(second->session->id));
}

TEST_F(SendKeyTest, AllSessionsUsed_NothingMoreIsReserved) {
  const auto key = made();
  const ReadGuard guard;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(key->reserve(64)) << i;
  EXPECT_EQ(code_of(key->reserve(64)), Code::session_ids_exhausted);
}

TEST_F(SendKeyTest, BeforeTheFirstMessage_NoSessionHasBegun) {
  const auto key = made();
  const ReadGuard guard;
  EXPECT_EQ(key->blocks_used(), 0u);
  const auto first = key->reserve(16);
  ASSERT_TRUE(first);
  const auto other = made({.session = 1000, .suffix = 0});
  EXPECT_FALSE(other->has_begun(first->session->id));
}

TEST_F(SendKeyTest, KindThatIsNoKey_IsRefused) {
  auto none = material(kAes256Gcm);
  none.kind = TransformKind{};
  EXPECT_EQ(code_of(SendKey::create(std::move(none), {}, services)), Code::internal);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
