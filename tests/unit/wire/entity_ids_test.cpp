#include "wire/entity_ids.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

TEST(EntityId, EachKind_IsRecognised) {
  EXPECT_TRUE(is_builtin(kSpdpWriter));
  EXPECT_TRUE(is_writer(kSpdpWriter));
  EXPECT_TRUE(has_key(kSpdpWriter));
  EXPECT_TRUE(is_reader(kStatelessMessageReader));
  EXPECT_FALSE(has_key(kStatelessMessageReader));
  EXPECT_TRUE(is_user_defined(EntityId{{0, 0, 1, 0x03}}));
  EXPECT_FALSE(is_writer(kEntityIdParticipant) || is_reader(kEntityIdParticipant));
}

}  // namespace
}  // namespace ddssec::rtps
