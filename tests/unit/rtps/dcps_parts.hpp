// The parts of a DataReader, each of which is tested alone.
#pragma once

#include <gmock/gmock.h>

#include "rtps/dcps/entity.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::dcps_parts {

using namespace testing;

struct Bare final : Entity {
  explicit Bare(ParticipantContext& context) : Entity(context) {}
  Status enable() override { return {}; }
  using Entity::changes_;
};

struct StatusChangesTest : ::testing::Test, UnservedContext {
  Bare entity{context};
};

}  // namespace ddssec::rtps::dcps_parts
