// Endpoints that cannot be created.
#include "rtps/participant/local_endpoints.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::code_of;
using testing::socketless::Node;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

TEST(Participant, InconsistentQos_IsRefused) {
  Node a(1);
  auto qos = default_writer_qos();
  qos.history.depth = 0;
  EXPECT_EQ(code_of(a.participant.create_writer(square(qos), a.listener, {})),
            Code::rtps_qos_inconsistent);
}

}  // namespace
}  // namespace ddssec::rtps::participants
