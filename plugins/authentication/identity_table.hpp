// Which identities and handshakes there are, and when they end.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <shared_mutex>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/event.hpp"
#include "plugins/authentication/handshake.hpp"
#include "plugins/authentication/remote_counts.hpp"
#include "plugins/authentication/unproven_octets.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::authentication {

/// One handshake of a pair; guarded by the pair's mutex.
struct PairHandshake {
  spi::HandshakeHandle handle;
  HandshakeState state;
  Bytes participant_data;  ///< what we sent as c.pdata
  std::chrono::nanoseconds since;
  UnprovenOctets::Share unproven = {};  ///< until it is established
};

/// A remote participant as one local participant knows it. Lock order: a pair's mutex before the
/// table's.
struct Pair {
  const spi::IdentityHandle local_handle;
  const spi::IdentityHandle remote_handle;
  const std::shared_ptr<const LocalIdentity> local;
  const Guid remote_guid;
  const spi::Challenge own_challenge;

  std::mutex mutex;  ///< guards what follows
  std::optional<spi::Challenge> announced_challenge = {};
  std::vector<PairHandshake> handshakes = {};
};

/// Who an event is about, as far as known.
struct PeerName {
  std::string subject;
  std::string guid;
  PeerProof proof = PeerProof::claimed;  ///< of the subject
};
inline PeerName our_name(const Guid& guid) { return {{}, guid.to_string(), PeerProof::not_a_peer}; }
inline Event event_about(const PeerName& name, const Error& error) {
  return Event(error, name.subject, name.guid, name.proof);
}

/// A remote identity belongs to the local one that met it: another local one that meets the same
/// participant has a remote identity, a handle, handshakes and an end of its own. Thread-safe.
class IdentityTable {
 public:
  IdentityTable(std::size_t most_local, const RemoteLimits& remote_limits)
      : most_local_(most_local), remote_limits_(remote_limits) {}

  /// Error: too_many_local_identities.
  Result<spi::IdentityHandle> add_local(std::shared_ptr<LocalIdentity> identity,
                                        const pki::ChainValid& chain);
  /// Errors: unknown_identity, identity_ended.
  Result<std::shared_ptr<LocalIdentity>> local(spi::IdentityHandle handle) const;

  struct RemoteClaim {
    Guid guid;
    spi::Token identity_token;
    std::string subject;  ///< the certificate's once the remote has authenticated
  };
  /// The pair, made with `own_challenge` if it is new. Errors: unknown_identity, identity_ended,
  /// too_many_remote_identities, too_many_identities_of_subject, identity_token_changed.
  Result<std::shared_ptr<Pair>> admit_remote(spi::IdentityHandle local, RemoteClaim claim,
                                             const spi::Challenge& own_challenge);
  /// A pair that exists. Errors: unknown_identity, also for another's remote; identity_ended.
  Result<std::shared_ptr<Pair>> pair(spi::IdentityHandle local, spi::IdentityHandle remote) const;
  /// Of a remote identity, whether it ended or not; null: there is none.
  std::shared_ptr<Pair> pair_of(spi::IdentityHandle remote) const;
  /// Error: unknown_handshake, identity_ended.
  Result<std::shared_ptr<Pair>> pair_of(spi::HandshakeHandle handle) const;

  spi::HandshakeHandle add_handshake(const std::shared_ptr<Pair>& pair);
  /// False if there is no such handshake.
  bool remove_handshake(spi::HandshakeHandle handle);

  /// The remote proved who it is; from now on its end counts. Success also for one that is gone.
  /// Errors: too_many_remote_identities, too_many_identities_of_subject.
  Status note_authenticated(spi::IdentityHandle remote, const pki::ChainValid& chain);

  /// A local one goes with its remote ones. False if there is no such identity.
  bool remove(spi::IdentityHandle handle);

  std::optional<WallTime> next_end() const;

  struct Ended {
    spi::IdentityHandle handle;
    PeerName peer;      ///< subject empty for a local identity
    std::string whose;  ///< subject whose certificate ended
    WallTime end;
  };
  /// Those that ended at `now` or before and were not marked; of one local identity and its remote
  /// ones, or (nil) of all.
  std::vector<Ended> ended_by(WallTime now, spi::IdentityHandle local) const;
  /// From now on they are refused. Needs no memory.
  void mark_ended(std::span<const Ended> ended);

  struct OurOwn {
    spi::IdentityHandle handle;
    std::shared_ptr<LocalIdentity> identity;
  };
  /// One local identity or (nil) all, as far as they have not ended.
  std::vector<OurOwn> locals(spi::IdentityHandle local) const;
  std::vector<std::shared_ptr<Pair>> pairs_of(spi::IdentityHandle local) const;
  struct Authenticated {
    spi::IdentityHandle handle;
    PeerName name;
    pki::Certificate certificate;
  };
  /// The remote identities of a local one that authenticated and have not ended.
  std::vector<Authenticated> authenticated_with(spi::IdentityHandle local) const;

  struct Revoked {
    spi::IdentityHandle handle;
    PeerName peer;  ///< subject empty for a local identity
    Error reason;
  };
  /// From now on they are refused, with their reason. Needs no memory.
  void mark_revoked(std::span<const Revoked> revoked);

  /// The remote identities of a local one that did not end; none for a remote one.
  std::vector<spi::IdentityHandle> peers_of(spi::IdentityHandle local) const;

  PeerName name_of(spi::IdentityHandle remote) const;

 private:
  struct Common {
    std::optional<WallTime> ends = {};
    std::string first_to_end = {};
    bool has_ended = false;
    std::optional<Error> revoked = {};  ///< why it ended, if not by time
  };
  struct Local : Common {
    std::shared_ptr<LocalIdentity> identity;
    std::map<Guid, std::int64_t> remotes = {};
    RemoteCounts counts = {};
  };
  struct Remote : Common {
    RemoteClaim claim;
    std::optional<pki::Certificate> authenticated = {};  ///< by which it did
    std::shared_ptr<Pair> pair;
    PeerName name() const;
  };
  using Remotes = std::unordered_map<std::int64_t, Remote>;

  /// Unique in the process: a host may have a table for each domain.
  static std::int64_t next_handle();
  Status renew_claim(spi::IdentityHandle remote, RemoteClaim claim);
  void forget(Remotes::iterator remote);
  void set_end(std::int64_t handle, Common& identity, WallTime end, std::string whose);
  void drop_end(std::int64_t handle, const Common& identity);
  void drop_handshakes(const Pair& pair);
  Common* find(std::int64_t handle);
  Result<const Local*> live_local(spi::IdentityHandle handle) const;
  Result<const Remote*> live_remote(spi::IdentityHandle handle) const;

  const std::size_t most_local_;
  const RemoteLimits remote_limits_;
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::int64_t, Local> locals_;
  Remotes remotes_;
  std::unordered_map<std::int64_t, std::shared_ptr<Pair>> handshakes_;
  std::map<const Pair*, std::vector<std::int64_t>> handshakes_of_;
  std::set<std::pair<WallTime, std::int64_t>> ends_;
};

}  // namespace ddssec::authentication
