// The data that the three interfaces of the cryptography plugin share.
#pragma once

#include <mutex>
#include <unordered_map>

#include "base/plugin_services.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/cryptography/entities.hpp"
#include "plugins/cryptography/subject_id.hpp"
#include "plugins/cryptography/token_ledger.hpp"

namespace ddssec::cryptography {

/// The shared state. Any change requires `mutex`.
struct CryptographyState {
  CryptographyState(const PluginServices& services, const AeadBackend& aead,
                    const CryptographyOptions& options, std::uint64_t first_generation);

  template <class H>
  Result<LocalParticipantCrypto*> local_participant(H handle) const {
    return registry.find<LocalParticipantCrypto>(handle.value, EntityKind::local_participant);
  }
  template <class H>
  Result<RemoteParticipantCrypto*> remote_participant(H handle) const {
    return registry.find<RemoteParticipantCrypto>(handle.value, EntityKind::remote_participant);
  }
  template <class H>
  Result<LocalEndpointCrypto*> local_endpoint(H handle, EntityKind kind) const {
    return registry.find<LocalEndpointCrypto>(handle.value, kind);
  }
  template <class H>
  Result<RemoteEndpointCrypto*> remote_endpoint(H handle, EntityKind kind) const {
    return registry.find<RemoteEndpointCrypto>(handle.value, kind);
  }
  /// Enters the endpoint's present keys into the routes of its participant. The caller holds the
  /// mutex.
  void publish_route(RemoteEndpointCrypto& endpoint);

  /// Takes a place among the receivers of the reader's writer, if it needs one and has none yet.
  /// The caller holds the mutex. Error: receiver_places_taken, after an event that names the peer.
  Status claim_place(RemoteEndpointCrypto& reader, const ParticipantPair& pair);
  void release_place(RemoteEndpointCrypto& reader) noexcept;

  /// Raises an event about the peer that owns `prefix`.
  void report(const Error& error, const std::optional<GuidPrefix>& prefix) const;

  /// Notes when the former keys of a remote entity end. Call it when the entity has got new keys.
  /// The caller holds the mutex.
  void note_former(std::int64_t handle, const RemoteKeys& remote_keys);

  const PluginServices services;
  const bool header_prefix_is_network_order;
  const bool host_checks_sources;
  RetiredObjects retired_objects;  // declared before the members that retire objects into it
  const KeyServices keys;
  Registry registry;
  mutable std::mutex mutex;
  std::unordered_map<std::int64_t, std::chrono::nanoseconds> former_until;  ///< guarded by mutex
  std::uint64_t pairs_made = 0;                                             ///< guarded by mutex
  std::uint64_t routes_made = 0;                                            ///< guarded by mutex
  mutable TokenLedger ledger;  ///< used for a host that does not check sources
  AnnouncementAccounts announcements = {};
  WorkAccounts work = {};
};

/// Returns the subject whose participants share places: the octets of the prefix that are bound to
/// the certificate's subject (DDS-Security 1.2, clause 10.3.3). A participant without a proven
/// prefix has its own places. It is identified by its identity handle, with a bit set that six
/// octets cannot have.
SubjectId subject_of(std::int64_t identity, const ParticipantPair& pair);

/// Returns the peer with that prefix that has authenticated with the local participant; nullptr if
/// there is none. Empty while another thread changes the peers.
std::optional<const RemoteParticipantCrypto*> find_peer(const CryptographyState& state,
                                                        const LocalParticipantCrypto& local,
                                                        const GuidPrefix& prefix);

/// Returns the entity kind that belongs to a handle type, on the local or on the remote side.
inline constexpr EntityKind local_kind(spi::DatawriterCryptoHandle) {
  return EntityKind::local_writer;
}
inline constexpr EntityKind local_kind(spi::DatareaderCryptoHandle) {
  return EntityKind::local_reader;
}
inline constexpr EntityKind remote_kind(spi::DatawriterCryptoHandle) {
  return EntityKind::remote_writer;
}
inline constexpr EntityKind remote_kind(spi::DatareaderCryptoHandle) {
  return EntityKind::remote_reader;
}

}  // namespace ddssec::cryptography
