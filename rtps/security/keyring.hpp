// The crypto handles of participants, endpoints and matched pairs, and the protection of messages
// with them in both directions.
#pragma once

#include "base/event.hpp"
#include "base/hash.hpp"
#include "rtps/reliability/key_age.hpp"
#include "rtps/reliability/send_protection.hpp"
#include "rtps/security/endpoint_keys.hpp"
#include "rtps/security/peer_event.hpp"
#include "rtps/security/pre_shared_messages.hpp"
#include "rtps/security/protection_phases.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

/// The protection with which a submessage arrived.
struct ReceivedProtection {
  bool message = false;         ///< it arrived inside a protected message of its sender
  Guid submessage = {};         ///< the endpoint whose key protected it; zero: none
  ProtectionId protection = 0;  ///< the one of the reader or writer that has the key
  KeyAge message_key = KeyAge::newest;
  KeyAge submessage_key = KeyAge::newest;

  /// The newest keys must have protected every layer: others may have one of them.
  KeyAge age() const {
    const bool is_former = (message && message_key == KeyAge::former) ||
                           (submessage != Guid{} && submessage_key == KeyAge::former);
    return is_former ? KeyAge::former : KeyAge::newest;
  }
};

/// True for the plain SEDP and liveliness endpoints. Cyclone DDS sends their data outside of
/// protected messages, Fast DDS inside.
bool is_plain_builtin(const EntityId& id);

/// Keeps the crypto handles, and protects and opens messages with them. No I/O, clock or lock. The
/// functions that protect and open messages allocate nothing.
class Keyring final : public SendProtection {
 public:
  Keyring(OwnSecurity& own, EventSink& events) : own_(own), events_(events) {}
  ~Keyring() override;

  // Local endpoints:
  /// Adds a local endpoint with its properties. `builtin_name` marks the volatile secure endpoints.
  Status add_local(const EntityId& id, const spi::EndpointSecurityAttributes& attributes,
                   std::string_view builtin_name = {}, spi::PropertyList properties = {});
  void remove_local(const EntityId& id);
  /// Returns the ciphers that a peer must support to receive from the endpoint; empty if it
  /// protects nothing itself.
  Result<std::optional<spi::CipherMask>> required_ciphers(const EntityId& id);
  /// Returns nullptr if the endpoint was never added.
  const spi::EndpointSecurityAttributes* attributes(const EntityId& id) const;
  /// The second protections, while the governance changes.
  ProtectionPhases& phases() { return phases_; }
  const ProtectionPhases& phases() const { return phases_; }

  // Remote participants:
  struct RemoteRegistration {
    spi::IdentityHandle identity;
    spi::PermissionsHandle permissions;
    std::shared_ptr<const spi::SharedSecret> secret;
    /// True if plain SEDP and liveliness also arrive inside protected messages. False for Cyclone
    /// DDS.
    bool wraps_plain_builtin = true;
    bool answers_key_requests = false;  ///< it sends the keys of an endpoint again if it is asked
  };
  Status add_remote(const GuidPrefix& prefix, RemoteRegistration remote);
  void remove_remote(const GuidPrefix& prefix);
  /// `protection`: see MessageKeys::tokens.
  Result<std::vector<spi::Token>> participant_tokens(const GuidPrefix& prefix,
                                                     ProtectionId protection = 0,
                                                     spi::KeyStage stage = spi::KeyStage::in_use);
  /// Returns true if the tokens replace other ones.
  Result<bool> set_participant_tokens(const GuidPrefix& prefix, std::span<const spi::Token> tokens,
                                      ProtectionId protection = 0);

  // Pairs of a local and a remote endpoint:
  /// Registers a pair, or finds it.
  Result<PairRegistration> register_pair(const EntityId& local, const Guid& remote,
                                         bool is_relay_only = false);
  /// Unregisters a pair. A pair whose keys stay may be registered again. The remote endpoint need
  /// not know of that, and does not send its keys again then. Returns the pair whose keys were
  /// dropped in exchange (IdlePairs), if any.
  std::optional<Guid> unregister_pair(const EntityId& local, const Guid& remote,
                                      AfterMatch after = AfterMatch::gone);
  enum class PairKind : std::uint8_t { unknown, ordinary, relay_only, suspended };
  PairKind kind_of(const EntityId& local, const Guid& remote) const;
  /// True if the pair is registered and not suspended.
  bool is_pair_registered(const EntityId& local, const Guid& remote) const;
  /// The state of the remote endpoint's keys for a pair.
  struct PairKeyState {
    bool have_come = false;           ///< also if the pair is suspended
    bool are_awaited = false;         ///< the pair is registered, and waits for them
    bool have_second_come = false;    ///< the same for its second protection
    bool are_second_awaited = false;  ///< the same; false if that is the former one
    /// True if there were too many pairs of the local endpoint with the subject of the remote one,
    /// so that some were unregistered (IdlePairs).
    bool may_be_dropped = false;
  };
  PairKeyState keys_for(const EntityId& local, const Guid& remote) const;
  /// Returns a digest of the keys that protect messages from the remote to the local endpoint. It
  /// stays the same as long as the keys do. Empty if the content is not authenticated.
  std::optional<Sha256Digest> keys_of(const EntityId& local, const Guid& remote) const;
  /// Sets the keys of the remote endpoint. `protection` is the one that has these keys; 0 means the
  /// first one. Returns true if the pair has become ready. Returns false for a suspended pair,
  /// which stays suspended, and for a pair that is ready under the second protection.
  Result<bool> set_endpoint_tokens(const EntityId& local, const Guid& remote,
                                   std::span<const spi::Token> tokens, ProtectionId protection = 0);

  // Key revision (DDS-Security 1.2, clause 9.8.10.4); see spi::CryptoKeyFactory:
  Result<spi::KeyRevision> revise();
  Status activate(spi::KeyRevision revision);
  /// Drops former keys whose time is over. True if the present ones are to be revised.
  bool end_former_keys() {
    factory().forget_former_keys();
    return factory().is_key_revision_due(own_.crypto()) || phases_.messages().needs_revision();
  }
  /// Returns the pairs of local endpoints with endpoints of that peer that have keys of their own,
  /// under either protection, without suspended ones.
  std::set<std::pair<EntityId, Guid>> pairs_with_keys(const GuidPrefix& prefix) const;
  /// Returns the tokens that the remote endpoint of such a pair needs: those in use, or those of
  /// the revision under way.
  Result<std::vector<spi::Token>> endpoint_tokens(const EntityId& local, const Guid& remote,
                                                  spi::KeyStage stage);

  // Receiving. Each call writes to `scratch`, which must have at least the size of the input.
  /// An open message.
  struct OpenMessage {
    BytesView plain;
    bool is_by_participant = false;  ///< protected by its sender's own key
    KeyAge age = KeyAge::newest;     ///< of that key
  };
  /// Opens a whole message. An unprotected message is returned unchanged, if it need not be
  /// protected. Errors: those of the plugin, rtps_protection_missing (a pre-shared key is required
  /// but was not used), secure_flags_unsupported (a pre-shared key was used where there is none).
  /// Errors are counted, and raise an event if they deserve one.
  Result<OpenMessage> open_message(const Header& header, BytesView message, MutableBytes scratch,
                                   MonotonicTime now);
  struct OpenSubmessage {
    BytesView plain;
    Guid by;
    ProtectionId protection;  ///< see ReceivedProtection
    KeyAge age;
  };
  Result<OpenSubmessage> open_submessage(const GuidPrefix& sender, BytesView group,
                                         MutableBytes scratch);
  /// Opens a payload. `reader` and `writer` must be a ready pair. An unprotected payload is
  /// returned unchanged.
  Result<BytesView> open_payload(const EntityId& reader, const Guid& writer, BytesView payload,
                                 const ReceivedProtection& opened_by, MutableBytes scratch);
  /// True if the submessage was protected as the governance requires. Refused submessages are
  /// counted.
  bool accepts(const EntityId& local, const Guid& remote, const ReceivedProtection& opened_by);
  /// Counts a message of which only the payload is protected, and whose payload does not confirm
  /// that the message ends an instance, or that it does not. Raises an event with `found`.
  void note_unproven_end(const EntityId& local, const Guid& remote, std::string found);
  const ProtectionCounters& counters() const { return counters_; }

  // SendProtection:
  Levels levels(const EntityId& sender) const override;
  Result<std::size_t> protect_payload(const EntityId& writer, BytesView plain,
                                      MutableBytes out) override;
  Result<std::size_t> protect_submessage(const EntityId& sender, const Guid& receiver,
                                         BytesView plain, MutableBytes out) override;
  Result<std::size_t> protect_message(Wrap wrap, const GuidPrefix& receiver, BytesView plain,
                                      MutableBytes out) override;
  void on_unprotectable(const Error& error) override;

 private:
  friend bool shows_receiver(const Keyring& keyring, const EntityId& writer, const Guid& reader,
                             const ReceivedProtection& opened_by);
  const LocalKeys* find(const EntityId& id) const { return rtps::find(locals_, id); }
  spi::CryptoKeyFactory& factory() { return own_.plugins().cryptography.key_factory(); }
  spi::CryptoKeyExchange& exchange() { return own_.plugins().cryptography.key_exchange(); }
  spi::CryptoTransform& transform() { return own_.plugins().cryptography.transform(); }
  std::unexpected<Error> undecodable_error(const Error& error, const GuidPrefix& sender);

  OwnSecurity& own_;
  EventSink& events_;
  Remotes remotes_;
  EndpointKeys keys_{own_, remotes_};
  Locals locals_;
  ProtectionPhases phases_{own_, remotes_, locals_, keys_};
  ProtectionCounters counters_;
  PreSharedMessages pre_shared_{own_, events_, counters_};
};

/// True if the protection also shows that a submessage of a remote reader was meant for the local
/// writer. INFO_DST is outside of a protected submessage, and a reader of another vendor has one
/// key for the writers of all participants. Writers of topics have random entity ids, which the
/// submessage contains. Those of builtin writers are the same everywhere.
bool shows_receiver(const Keyring& keyring, const EntityId& writer, const Guid& reader,
                    const ReceivedProtection& opened_by);

/// True if nothing but the payload of a submessage shows that it comes from the remote endpoint.
bool is_only_payload_proven(const Keyring& keyring, const EntityId& local, const Guid& remote,
                            const ReceivedProtection& opened_by);

}  // namespace ddssec::rtps
