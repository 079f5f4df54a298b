// The record and its socket, which exist if the environment asks for them.
#include "base/status_service.hpp"

#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/support/recorded_events.hpp"
#include "tests/unit/base/status_socket.hpp"

namespace ddssec {
namespace {

using testing::HasSubstr;

class Service : public Server {
 protected:
  ~Service() override { ::unsetenv("DDSSEC_STATUS_DIR"); }
  test::RecordedEvents log_;
};

TEST_F(Service, UnsetOrEmptyVariable_OpensNoSocket) {
  ::unsetenv("DDSSEC_STATUS_DIR");
  EXPECT_EQ(shared_status_record(&log_), nullptr);
  ::setenv("DDSSEC_STATUS_DIR", "", 1);
  EXPECT_EQ(shared_status_record(&log_), nullptr);
  EXPECT_TRUE(log_.all.empty());
}

TEST_F(Service, AllUsersOfAProcess_ShareOneRecordUntilTheLastLeaves) {
  ::setenv("DDSSEC_STATUS_DIR", folder_.path().c_str(), 1);
  auto first = shared_status_record(&log_);
  auto second = shared_status_record(&log_);
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first, second);
  EXPECT_THAT(answer_at(path()), HasSubstr("ddssec-status/1"));
  first.reset();
  EXPECT_TRUE(has_sockets());
  second.reset();
  EXPECT_FALSE(has_sockets());
}

TEST_F(Service, ChildOfAProcessThatShows_ShowsNothing) {
  ::setenv("DDSSEC_STATUS_DIR", folder_.path().c_str(), 1);
  const auto record = shared_status_record(&log_);
  EXPECT_EQ(in_child([&] { return shared_status_record(&log_) == nullptr; }), 0);
}

TEST_F(Service, FolderThatCannotServe_IsReportedOnce) {
  ::setenv("DDSSEC_STATUS_DIR", "/nowhere/at/all", 1);
  EXPECT_EQ(shared_status_record(&log_), nullptr);
  EXPECT_EQ(shared_status_record(&log_), nullptr);
  ASSERT_EQ(log_.all.size(), 1u);
  EXPECT_EQ(log_.all[0].error.code(), Code::status_not_served);
  EXPECT_EQ(log_.all[0].proof, PeerProof::not_a_peer);
}

}  // namespace
}  // namespace ddssec
