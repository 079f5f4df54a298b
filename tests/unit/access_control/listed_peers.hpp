// A peer whose permissions end in 20 s, and a renewal list of the local participant.
#pragma once

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {

/// The talker is the local participant and has a renewal list. The listener is the peer, whose
/// permissions end 20 s from now.
class ListedPeers : public AccessControlTest {
 protected:
  ListedPeers() {
    own_ = ours({}, "").value_or(spi::PermissionsHandle{});
    EXPECT_TRUE(own_);
    meet(document({"t"}));
    log.all.clear();
  }

  Result<spi::PermissionsHandle> ours(const std::string& permissions_uri, const std::string& text) {
    auto all = properties(signed_document(governance::to_xml(governance_document)),
                          text.empty() ? open_permissions(kTalker) : text);
    all.push_back({std::string(spi::property::kRenewalList), "file:" + path_, false});
    for (auto& one : all)
      if (!permissions_uri.empty() && one.name == spi::property::kPermissions)
        one.value = permissions_uri;
    return plugin->validate_local_permissions(kLocalIdentity, 0, all);
  }
  void meet(const std::string& text, const spi::SessionFacts& facts = {}) {
    peer_ = remote(text, facts).value_or(spi::PermissionsHandle{});
    EXPECT_TRUE(peer_);
  }
  /// Returns permissions of the listener to publish `names`.
  std::string document(std::vector<std::string> names, std::chrono::seconds from = -24h,
                       std::chrono::seconds until = 20s, const char* subject = kListener) const {
    auto out = grant(subject, {publish_rule(true, std::move(names))});
    out.validity = {kNow + from, kNow + until};
    return signed_permissions({out});
  }
  Status show(const std::string& text) {
    return plugin->renew_remote_permissions(peer_, permissions_token(),
                                            credential(authorities().listener, text));
  }
  void put(const std::vector<std::string>& files) {
    pki::RenewalList list;
    for (const auto& one : files) list.permissions.push_back(to_bytes(as_bytes(one)));
    folder_.replace("renewed.pem", list.text().value());
  }
  std::vector<spi::PermissionsHandle> poll(std::chrono::seconds after = 5s) {
    clock.advance(after);
    return plugin->expire();
  }
  std::vector<spi::PermissionsHandle> pass_the_end() {
    std::vector<spi::PermissionsHandle> ended;
    for (int i = 0; i < 16; ++i)
      for (const auto handle : poll()) ended.push_back(handle);
    return ended;
  }
  std::vector<Code> codes() {
    std::vector<Code> out;
    for (const auto& event : log.all) out.push_back(event.error.code());
    log.all.clear();
    return out;
  }
  bool may_publish(std::string_view topic) {
    return plugin->check_remote_datawriter(peer_, 0, {.topic_name = topic}).has_value();
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/renewed.pem";
  spi::PermissionsHandle own_, peer_;
};

}  // namespace ddssec::access_control
