// A peer whose permissions a test replaces within its session.
#pragma once

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {

/// The listener is the peer. Its documents end after `lifetime` if a test says nothing else.
class ListenerPeerTest : public AccessControlTest {
 protected:
  explicit ListenerPeerTest(std::chrono::seconds lifetime) : lifetime_(lifetime) {}

  void meet(const std::string& text, const spi::SessionFacts& facts = {}) {
    peer_ = remote(text, facts).value_or(spi::PermissionsHandle{});
    EXPECT_TRUE(peer_);
  }
  /// The listener may publish `names`.
  std::string document(std::vector<std::string> names, std::chrono::seconds from = -24h,
                       std::optional<std::chrono::seconds> until = {},
                       const char* subject = kListener) const {
    auto out = grant(subject, {publish_rule(true, std::move(names))});
    out.validity = {kNow + from, kNow + until.value_or(lifetime_)};
    return signed_permissions({out});
  }
  Result<bool> show(const std::string& text) {
    return plugin->renew_remote_permissions(peer_, permissions_token(),
                                            credential(authorities().listener, text));
  }
  bool may_publish(std::string_view topic) {
    return plugin->check_remote_datawriter(peer_, 0, {.topic_name = topic}).has_value();
  }

  spi::PermissionsHandle peer_;

 private:
  std::chrono::seconds lifetime_;
};

}  // namespace ddssec::access_control
