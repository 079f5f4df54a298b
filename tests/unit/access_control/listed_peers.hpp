// A peer whose permissions end in 20 s, and a renewal list of the local participant.
#pragma once

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/listener_peer.hpp"

namespace ddssec::access_control {

/// The talker is the local participant and has a renewal list. The listener is the peer, whose
/// permissions end 20 s from now.
class ListedPeers : public ListenerPeerTest {
 protected:
  ListedPeers() : ListenerPeerTest(20s) {
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
  void put(const std::vector<std::string>& files) {
    pki::RenewalList list;
    for (const auto& one : files) list.permissions.push_back(to_bytes(as_bytes(one)));
    folder_.replace("renewed.pem", list.text().value());
  }
  std::vector<spi::PermissionsHandle> pass_the_end() {
    std::vector<spi::PermissionsHandle> ended;
    for (int i = 0; i < 16; ++i)
      for (const auto handle : poll()) ended.push_back(handle);
    return ended;
  }
  std::vector<Code> codes() {
    const auto out = log.codes();
    log.all.clear();
    return out;
  }
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/renewed.pem";
  spi::PermissionsHandle own_;
};

}  // namespace ddssec::access_control
