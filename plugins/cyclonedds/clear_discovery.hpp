// Ends the unprotected discovery of a peer's endpoints, where governance protects that of all
// topics. Cyclone's core believes clear announcements in the name of an authenticated participant
// under every kind of protection: a stranger could remove its endpoints, move them to another
// address, or invent some, with one datagram. It even believes that a builtin writer is gone. So
// we tell our own core, in the peer's name, that the two writers of clear announcements are. The
// core then knows no writer from which such an announcement could come. The same goes for the
// writers of type lookup where cryptography hides types from the core: it needs no lookup then, and
// some end its process. Not for the unprotected writer of liveliness: version 0.10.2 of the core
// uses that one under every liveliness_protection_kind.
#pragma once

#include <array>
#include <chrono>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// What becomes of a peer's writers of type lookup.
enum class TypeLookup : bool { stays, ends };

/// A whole RTPS message to participant `own`, in the name of `peer`.
Bytes write_end_of_clear_discovery(const GuidPrefix& peer, const GuidPrefix& own,
                                   TypeLookup lookup);

/// Where a participant receives discovery by unicast over UDP, as it says in its
/// ParticipantBuiltinTopicData, a big-endian parameter list; at most eight addresses.
std::vector<spi::UdpAddress> discovery_addresses(BytesView participant_data);

/// Which peers it is to be said of, and when. Thread-safe.
class ClearDiscovery {
 public:
  using Duration = std::chrono::nanoseconds;
  /// After the handshake. The core makes the builtin endpoints of the peer some time after it, and
  /// a datagram may be lost; said twice it changes nothing.
  static constexpr std::array<std::chrono::milliseconds, 12> kTimes{
      {std::chrono::milliseconds(0), std::chrono::milliseconds(10), std::chrono::milliseconds(25),
       std::chrono::milliseconds(50), std::chrono::milliseconds(100),
       std::chrono::milliseconds(200), std::chrono::milliseconds(400), std::chrono::seconds(1),
       std::chrono::seconds(2), std::chrono::seconds(5), std::chrono::seconds(15),
       std::chrono::seconds(60)}};

  explicit ClearDiscovery(const Clock& clock) : clock_(clock) {}

  /// Where a local participant receives discovery.
  void hears_at(spi::IdentityHandle local, std::vector<spi::UdpAddress> addresses);
  void remove_local(spi::IdentityHandle local);

  /// The two have authenticated. `own`: of the local participant.
  void established(spi::IdentityHandle local, const GuidPrefix& own, const Guid& peer,
                   TypeLookup lookup);
  void lost(const Guid& peer);

  struct Due {
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  std::vector<Due> due();
  /// How long until there is something due; nothing: never.
  std::optional<Duration> next() const;

 private:
  struct Peer {
    spi::IdentityHandle local;
    GuidPrefix own;
    TypeLookup lookup;
    Duration since;
    std::size_t said = 0;  ///< of kTimes
  };

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<spi::IdentityHandle, std::vector<spi::UdpAddress>> addresses_;
  std::map<Guid, Peer> peers_;  ///< of whom it was not said often enough
};

}  // namespace ddssec::cyclonedds
