// The table of identities and handshakes, with their expiry.
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
#include "plugins/authentication/session_renewal.hpp"
#include "plugins/authentication/unproven_octets.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::authentication {

/// One handshake of a pair; guarded by the pair's mutex.
struct PairHandshake {
  spi::HandshakeHandle handle;
  HandshakeState state;
  Bytes participant_data;             ///< the c.pdata that was sent
  std::chrono::nanoseconds began_at;  ///< monotonic time at which the host began it
  /// Memory share of the peer's request, until the handshake is established.
  UnprovenOctets::Share unproven = {};
  /// The last offer to the peer, once the handshake is established.
  std::optional<RenewalOffer> offer = {};
};

/// A remote participant as one local participant knows it. Lock order: a pair's mutex before the
/// table's.
struct IdentityPair {
  const spi::IdentityHandle local_handle;
  const spi::IdentityHandle remote_handle;
  const std::shared_ptr<const OwnIdentity> local;
  const Guid remote_guid;
  const spi::Challenge own_challenge;

  std::mutex mutex;  ///< guards the members below
  std::optional<spi::Challenge> announced_challenge = {};
  std::vector<PairHandshake> handshakes = {};
  /// Keys of replies that the host gave up; see KeptRequests.
  std::vector<ReplyKey> reply_keys = {};
};

/// The participant that an event is about, as far as known.
struct PeerName {
  std::string subject;
  std::string guid;
  PeerProof proof = PeerProof::claimed;  ///< the proof of the subject
};
inline PeerName our_name(const Guid& guid) { return {{}, guid.to_string(), PeerProof::not_a_peer}; }
inline Event event_about(const PeerName& name, const Error& error) {
  return Event(error, name.subject, name.guid, name.proof);
}

/// The table. A remote identity belongs to one local identity. If another local identity discovers
/// the same participant, it has its own remote identity, handle, handshakes and expiry.
/// Thread-safe.
class IdentityTable {
 public:
  IdentityTable(std::size_t max_local, const RemoteLimits& remote_limits)
      : max_local_(max_local), remote_limits_(remote_limits) {}

  /// Adds a local identity that expires with `chain`. Error: too_many_local_identities.
  Result<spi::IdentityHandle> add_local(std::shared_ptr<OwnIdentity> identity,
                                        const pki::ValidChain& chain);
  /// Returns a local identity. Errors: unknown_identity, identity_ended, or the reason of its
  /// revocation.
  Result<std::shared_ptr<OwnIdentity>> local(spi::IdentityHandle handle) const;

  struct RemoteClaim {
    Guid guid;
    std::string subject;  ///< as claimed; from the certificate once the remote has authenticated
  };
  /// Returns the pair; created with `own_challenge` if it is new. If it exists, the claim replaces
  /// the first one, unless the remote has authenticated. Errors: unknown_identity, identity_ended,
  /// too_many_remote_identities, too_many_identities_of_subject.
  Result<std::shared_ptr<IdentityPair>> admit_remote(spi::IdentityHandle local, RemoteClaim claim,
                                                     const spi::Challenge& own_challenge);
  /// Returns an existing pair. Errors: unknown_identity (also if the remote identity belongs to
  /// another local one), identity_ended.
  Result<std::shared_ptr<IdentityPair>> pair(spi::IdentityHandle local,
                                             spi::IdentityHandle remote) const;
  /// Returns the pair of a remote identity, expired or not; nullptr if there is none.
  std::shared_ptr<IdentityPair> pair_of(spi::IdentityHandle remote) const;
  /// Returns the pair of a handshake. Errors: unknown_handshake, identity_ended.
  Result<std::shared_ptr<IdentityPair>> pair_of(spi::HandshakeHandle handle) const;

  /// Adds a handshake of the pair, and returns its new handle.
  spi::HandshakeHandle add_handshake(const std::shared_ptr<IdentityPair>& pair);
  /// Removes a handshake. False if there is no such handshake.
  bool remove_handshake(spi::HandshakeHandle handle);

  /// Notes that a local identity has a renewed certificate: it then expires with `chain`. Its
  /// remote identities do so when they have authenticated again. Does nothing if it has expired.
  void set_renewed(spi::IdentityHandle local, const pki::ValidChain& chain);

  struct Proofs {
    const pki::ValidChain& peer;
    const pki::ValidChain& own;  ///< chain of our certificate that the peer has seen
    /// True if the peer keeps the session after the end of our certificate.
    bool peer_keeps_session = false;
    bool peer_reads_lists = false;  ///< see JudgedPeer::reads_lists
  };
  /// Notes that the remote identity has authenticated: it then expires with the certificate that
  /// ends first. Our own certificate counts because the peer ends the session with it, unless the
  /// peer keeps its sessions. Also success if the identity was removed meanwhile. Errors:
  /// too_many_remote_identities, too_many_identities_of_subject.
  Status set_authenticated(spi::IdentityHandle remote, const Proofs& proofs);
  /// Notes that other CAs have verified the same certificates. The chains of these CAs may end
  /// earlier or later.
  void set_verified_again(spi::IdentityHandle remote, const Proofs& proofs);
  /// Notes that the session goes on with certificates that are later than those of its handshake:
  /// one of the peer, by the renewal list, or ours, or both. Does nothing if the session has ended.
  /// The last two members of `proofs` are not used.
  void extend_by_renewal_list(spi::IdentityHandle remote, const Proofs& proofs);

  /// Removes an identity, and with a local one its remote ones. False if there is no such identity.
  bool remove(spi::IdentityHandle handle);

  /// Returns the earliest expiry of all identities; empty if none will expire.
  std::optional<WallTime> next_end() const;

  struct EndedIdentity {
    spi::IdentityHandle handle;
    PeerName peer;      ///< the subject is empty for a local identity
    std::string whose;  ///< the subject whose certificate ended
    WallTime end;
    bool own_certificate_ended =
        false;              ///< true for a remote one whose session our certificate ended
    std::string note = {};  ///< the reason why the renewal list does not help
  };
  /// Returns identities that expired at `now` or earlier and are not marked yet: those of one local
  /// identity and its remote ones, or of all (nil).
  std::vector<EndedIdentity> ended_by(WallTime now, spi::IdentityHandle local) const;
  /// Marks these identities: from now on they are refused. Allocates no memory.
  void mark_ended(std::span<const EndedIdentity> ended);

  struct OwnIdentityEntry {
    spi::IdentityHandle handle;
    std::shared_ptr<OwnIdentity> identity;
  };
  /// Returns one local identity, or all (nil). Expired ones are left out.
  std::vector<OwnIdentityEntry> locals(spi::IdentityHandle local) const;
  /// Returns all pairs of a local identity.
  std::vector<std::shared_ptr<IdentityPair>> pairs_of(spi::IdentityHandle local) const;
  struct AuthenticatedPeer {
    spi::IdentityHandle handle;
    PeerName name;
    pki::Certificate certificate;            ///< the certificate of its handshake
    std::optional<pki::Certificate> listed;  ///< the later one on the renewal list
    pki::Certificate own;                    ///< our certificate that the peer has seen
    bool reads_lists;                        ///< see JudgedPeer::reads_lists
    /// Returns the certificate with which the session ends.
    const pki::Certificate& latest() const { return listed ? *listed : certificate; }
  };
  /// Returns the remote identities of a local one that have authenticated and have not expired.
  std::vector<AuthenticatedPeer> authenticated_with(spi::IdentityHandle local) const;
  /// Returns a remote identity that has authenticated; empty if it has not, or has expired.
  std::optional<AuthenticatedPeer> authenticated(spi::IdentityHandle remote) const;

  struct RevokedIdentity {
    spi::IdentityHandle handle;
    PeerName peer;  ///< the subject is empty for a local identity
    Error reason;
  };
  /// Marks these identities: from now on they are refused with their reason. Allocates no memory.
  void mark_revoked(std::span<const RevokedIdentity> revoked);

  /// Returns the unexpired remote identities of a local one; empty for a remote one.
  std::vector<spi::IdentityHandle> peers_of(spi::IdentityHandle local) const;

  /// Returns the name of a remote identity for events; empty fields if it is unknown.
  PeerName name_of(spi::IdentityHandle remote) const;

 private:
  struct Common {
    std::optional<WallTime> ends = {};
    std::string first_to_end = {};
    bool has_ended = false;
    std::optional<Error> revoked = {};  ///< the reason of a revocation
  };
  struct Local : Common {
    std::shared_ptr<OwnIdentity> identity;
    std::map<Guid, std::int64_t> remotes = {};
    RemoteCounts counts = {};
  };
  struct Remote : Common {
    RemoteClaim claim;
    /// The certificate with which it authenticated.
    std::optional<pki::Certificate> authenticated = {};
    std::optional<pki::Certificate> listed = {};    ///< the later one on the renewal list
    std::optional<pki::Certificate> own_seen = {};  ///< our certificate with which it authenticated
    std::shared_ptr<IdentityPair> pair;
    bool keeps_session = false;  ///< true if it keeps the session after the end of our certificate
    bool reads_lists = false;
    bool ends_with_ours = false;
    PeerName name() const;
    const std::optional<pki::Certificate>& latest() const {
      return listed ? listed : authenticated;
    }
    AuthenticatedPeer as_authenticated(std::int64_t handle) const;
  };
  using Remotes = std::unordered_map<std::int64_t, Remote>;

  /// Returns the next handle. It is unique within the process, because a host may have one table
  /// for each domain.
  static std::int64_t next_handle();
  Status renew_claim(spi::IdentityHandle remote, RemoteClaim claim);
  void forget(Remotes::iterator remote);
  void set_end_of(std::int64_t handle, Remote& remote, const Proofs& proofs);
  void set_end(std::int64_t handle, Common& identity, WallTime end, std::string whose);
  void drop_end(std::int64_t handle, const Common& identity);
  void drop_handshakes(const IdentityPair& pair);
  Common* find(std::int64_t handle);
  Result<const Local*> live_local(spi::IdentityHandle handle) const;
  Result<const Remote*> live_remote(spi::IdentityHandle handle) const;

  const std::size_t max_local_;
  const RemoteLimits remote_limits_;
  mutable std::shared_mutex mutex_;
  std::unordered_map<std::int64_t, Local> locals_;
  Remotes remotes_;
  std::unordered_map<std::int64_t, std::shared_ptr<IdentityPair>> handshakes_;
  std::map<const IdentityPair*, std::vector<std::int64_t>> handshakes_of_;
  std::set<std::pair<WallTime, std::int64_t>> ends_;
};

}  // namespace ddssec::authentication
