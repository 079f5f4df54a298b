// A host whose events a test sees.
#pragma once

#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::boundaries {

struct Boundary : testing::Test {
  std::vector<Event> events;
  Host host{std::make_unique<Recorder>(events)};
  Refusal refusal;
};

}  // namespace ddssec::cyclonedds::boundaries
