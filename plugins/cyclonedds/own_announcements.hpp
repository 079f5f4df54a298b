// Announcements (SPDP) of local participants that the plugin sends itself, to a peer whose session
// has ended. Both hosts have dropped each other then, and each waits for the other's next periodic
// announcement: up to 8 s in Cyclone DDS 0.10.2. A host that discovers a participant by an
// announcement that is not directed at it answers with its own at once, so one is enough.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// Returns a whole RTPS message that announces participant `own` to all who receive it.
/// `participant_data` is what the host gives a handshake (c.pdata): the parameter list of the
/// announcement in big-endian form. Returns nothing if it is not the data of `own` with an identity
/// token: without a token, a peer would take the participant for one without security.
std::optional<Bytes> write_announcement(const GuidPrefix& own, BytesView participant_data);

/// The announcements that are to be sent. Thread-safe.
class OwnAnnouncements {
 public:
  using Duration = std::chrono::nanoseconds;
  /// The time from a reset to the announcement. The peer has followed the reset by then, and has
  /// itself reset this process (AuthenticationAdapter::follow_resets); a session that begins
  /// earlier could be ended by that.
  static constexpr Duration kAfterReset = std::chrono::milliseconds(900);
  /// The most octets of participant data that are kept for each local participant, and the most
  /// announcements that wait.
  static constexpr std::size_t kMaxOctets = 16 * 1024;
  static constexpr std::size_t kMaxWaiting = 256;

  /// Keeps the announcement of a local participant, which the host shows to a handshake.
  void note_data(spi::IdentityHandle local, const GuidPrefix& prefix, BytesView participant_data);
  void remove_local(spi::IdentityHandle local);

  /// Notes that a reset was sent to the peer, which the host no longer discovers.
  void note_reset(spi::IdentityHandle local, const Guid& peer,
                  const std::vector<spi::UdpAddress>& to, Duration now);
  struct Announcement {
    spi::IdentityHandle local;
    Guid peer;
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  /// Removes and returns those that are due.
  std::vector<Announcement> take_due(Duration now);

 private:
  struct Waiting {
    Duration at;
    std::vector<spi::UdpAddress> to;
  };

  std::mutex mutex_;
  std::map<spi::IdentityHandle, Bytes> messages_;
  std::map<std::pair<spi::IdentityHandle, Guid>, Waiting> waiting_;
};

}  // namespace ddssec::cyclonedds
