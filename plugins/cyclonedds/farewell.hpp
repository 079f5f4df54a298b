// A farewell in our own name, for a peer that answers nothing. Its core may have believed an
// announcement that a stranger forged in our name, one without security: then it asks no plugin,
// ignores our handshake, and our honest announcements renew what it believes. It also believes a
// clear farewell, but of unauthenticated participants only. After it, it discovers us anew.
#pragma once

#include <map>
#include <mutex>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// A whole RTPS message: participant `own` is disposed and unregistered (RTPS 8.5.3.3), said to
/// participant `peer` alone (INFO_DST).
Bytes write_farewell(const GuidPrefix& own, const GuidPrefix& peer);

/// Our participants, which may have to say it. Thread-safe.
class Farewells {
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
