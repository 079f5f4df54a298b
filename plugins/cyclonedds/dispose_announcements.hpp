// A dispose announcement in the local participant's name, for a peer that does not answer. An
// attacker may have forged an announcement without security in the local participant's name. A
// peer's core that trusted it asks no plugin and ignores the handshake, and the honest
// announcements only renew its wrong state. The core also trusts an unprotected dispose
// announcement, but only of unauthenticated participants. After it, the core discovers the local
// participant again.
#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Returns a whole RTPS message for participant `peer` only (INFO_DST). It disposes and unregisters
/// participant `own` (RTPS 8.5.3.3).
Bytes write_dispose_announcement(const GuidPrefix& own, const GuidPrefix& peer);

/// The local participants, which may have to send dispose announcements. Thread-safe.
class DisposeAnnouncements {
 public:
  void add_local(spi::IdentityHandle local, const GuidPrefix& prefix);
  void remove_local(spi::IdentityHandle local);

  struct Local {
    spi::IdentityHandle handle;
    GuidPrefix prefix;
  };
  std::vector<Local> locals() const;

 private:
  mutable std::mutex mutex_;
  std::map<spi::IdentityHandle, Local> locals_;
};

}  // namespace ddssec::cyclonedds
