// What a plugin context reports: each refusal once. No exception gets through to the host.
#include "plugins/cyclonedds/host.hpp"

#include "plugins/cyclonedds/c_boundary.hpp"
#include "tests/unit/cyclonedds/boundaries.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::boundaries {
namespace {

TEST_F(Boundary, OwnEventOfPlugin_IsNotRepeated) {
  const auto raise_and_refuse = [&]() -> Status {
    host.services().events.raise(Event(Error(Code::malformed), "CN=peer"));
    return fail(Code::malformed);
  };
  EXPECT_EQ(allowed_at_c_boundary(host, &refusal, raise_and_refuse), 0);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].peer_subject, "CN=peer");
}

TEST_F(Boundary, ASinkThatThrows_LetsNothingThrough) {
  struct Throwing final : EventSink {
    void raise(const Event&) override { throw std::bad_alloc(); }
  };
  Host broken(std::make_unique<Throwing>());
  EXPECT_EQ(
      allowed_at_c_boundary(broken, &refusal, []() -> Status { return fail(Code::malformed); }), 0);
  EXPECT_EQ(refusal.reason(), Code::malformed);
}

}  // namespace
}  // namespace ddssec::cyclonedds::boundaries
