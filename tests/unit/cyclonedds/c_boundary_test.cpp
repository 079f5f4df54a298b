#include "plugins/cyclonedds/c_boundary.hpp"

#include <stdexcept>

#include "tests/unit/cyclonedds/boundaries.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::boundaries {
namespace {

TEST_F(Boundary, Success_TouchesNothing) {
  EXPECT_EQ(allowed_at_c_boundary(host, &refusal, [] { return Status{}; }), 1);
  EXPECT_EQ(refusal.code, 0);
  EXPECT_EQ(refusal.message, nullptr);
  EXPECT_TRUE(events.empty());
}

TEST_F(Boundary, Failure_IsACodeAndOneEventWithTheSentence) {
  const auto refuse = []() -> Status {
    return fail(Code::malformed, {.document = "c.pdata", .found = "3 octets"});
  };
  EXPECT_EQ(allowed_at_c_boundary(host, &refusal, refuse), 0);
  EXPECT_EQ(refusal.reason(), Code::malformed);
  EXPECT_EQ(refusal.minor_code, 0);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].error.to_sentence(), refuse().error().to_sentence());
  EXPECT_EQ(events[0].error.code(), Code::malformed);

  // The same refusal within the interval raises no further event.
  Refusal again;
  allowed_at_c_boundary(host, &again, refuse);
  EXPECT_EQ(again.reason(), Code::malformed);
  EXPECT_EQ(events.size(), 1u);
}

// The host logs the exception's message beside our line.
TEST_F(Boundary, Failure_MessageForTheHost_NamesTheReasonAndNoDetails) {
  const auto refuse = []() -> Status {
    return fail(Code::malformed, {.document = "c.pdata", .found = "3 octets"});
  };
  allowed_at_c_boundary(host, &refusal, refuse);
  EXPECT_THAT(refusal.text(), testing::HasSubstr(info(Code::malformed).summary));
  EXPECT_THAT(refusal.text(), testing::HasSubstr("[malformed]"));
  EXPECT_THAT(refusal.text(), testing::Not(testing::HasSubstr("c.pdata")));
  EXPECT_THAT(refusal.text(), testing::Not(testing::HasSubstr(info(Code::malformed).hint)));
}

TEST_F(Boundary, Notice_BeforeARefusal_TakesNoEventFromIt) {
  allowed_at_c_boundary(host, &refusal, [&]() -> Status {
    host.notice(Event(Error(Code::clock_step_undone)));
    return fail(Code::malformed);
  });
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1].error.code(), Code::malformed);
}

TEST_F(Boundary, NullException_IsTolerated) {
  EXPECT_EQ(allowed_at_c_boundary(host, nullptr, []() -> Status { return fail(Code::malformed); }),
            0);
  EXPECT_EQ(events.size(), 1u);
}

TEST_F(Boundary, ThrownExceptions_Deny) {
  EXPECT_EQ(allowed_at_c_boundary(host, &refusal,
                                  []() -> Status { throw std::runtime_error("what it said"); }),
            0);
  EXPECT_EQ(refusal.reason(), Code::internal);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_THAT(events[0].error.to_sentence(), testing::HasSubstr("what it said"));

  Refusal unknown;
  EXPECT_EQ(allowed_at_c_boundary(host, &unknown, []() -> Status { throw 42; }), 0);
  EXPECT_EQ(unknown.reason(), Code::internal);

  Refusal memory;
  EXPECT_EQ(allowed_at_c_boundary(host, &memory, []() -> Status { throw std::bad_alloc(); }), 0);
  EXPECT_EQ(memory.reason(), Code::out_of_memory);

  Refusal thread;
  const auto no_thread = []() -> Status {
    throw std::system_error(std::make_error_code(std::errc::resource_unavailable_try_again));
  };
  EXPECT_EQ(allowed_at_c_boundary(host, &thread, no_thread), 0);
  EXPECT_EQ(thread.reason(), Code::out_of_memory);
}

}  // namespace
}  // namespace ddssec::cyclonedds::boundaries
