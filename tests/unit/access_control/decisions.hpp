// A governance document with and without access control, and participants with a few rules.
#pragma once

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {

using spi::EndpointRequest;

using Partitions = std::vector<std::string_view>;

class Decisions : public AccessControlTest {
 protected:
  /// The topic "open" has no access control, "written" has write control only, the others have
  /// both.
  void SetUp() override {
    auto& rules = governance_document.domain_rules[0].topic_rules;
    rules = {{.topic_expression = "open",
              .enable_read_access_control = false,
              .enable_write_access_control = false},
             {.topic_expression = "written", .enable_read_access_control = false},
             {.topic_expression = "closed*"}};
  }
  spi::PermissionsHandle with(std::vector<governance::GrantRule> rules,
                              bool default_allow = false) {
    auto content = grant(kTalker, std::move(rules));
    content.default_allow = default_allow;
    const auto handle = local(signed_permissions({content}));
    EXPECT_TRUE(handle) << handle.error().to_sentence();
    return *handle;
  }
  spi::PermissionsHandle peer_with(std::vector<governance::GrantRule> rules,
                                   bool default_allow = false) {
    if (!local_) local_ = with({rule(true)});
    auto content = grant(kListener, std::move(rules));
    content.default_allow = default_allow;
    const auto handle = remote(signed_permissions({content}));
    EXPECT_TRUE(handle) << handle.error().to_sentence();
    return *handle;
  }
  spi::PermissionsHandle local_;
};

inline spi::AccessControl::Match match(const EndpointRequest& local, bool remote_writes = true) {
  return {.remote_writes = remote_writes,
          .local = local,
          .remote = GuidPrefix{{0x81, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}}};
}

}  // namespace ddssec::access_control
