// Which crypto handles stand for which participants, endpoints and matched pairs, and what they do
// to octets on their way out and in.
#pragma once

#include <map>
#include <unordered_map>

#include "base/event.hpp"
#include "base/hash.hpp"
#include "rtps/reliability/send_protection.hpp"
#include "rtps/security/peer_event.hpp"
#include "rtps/security/pre_shared_messages.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {

/// What a received submessage was protected by.
struct Shield {
  bool message = false;  ///< came inside a protected message of its sender
  Guid submessage = {};  ///< the endpoint whose key protected it; zero: none
};

/// Of plain SEDP or liveliness. Cyclone DDS sends these outside of protected messages, Fast DDS
/// inside.
bool is_plain_builtin(const EntityId& id);

/// No I/O, clock or lock. Of the message path nothing allocates.
class Keyring final : public SendProtection {
 public:
  Keyring(OwnSecurity& own, EventSink& events) : own_(own), events_(events) {}
  ~Keyring() override;

  // Local endpoints.
  /// `properties`: the endpoint's own; the volatile secure ones are marked by `builtin_name`.
  Status add_local(const EntityId& id, const spi::EndpointSecurityAttributes& attributes,
                   std::string_view builtin_name = {}, spi::PropertyList properties = {});
  void remove_local(const EntityId& id);
  /// What one must understand to hear it; nothing if it protects nothing itself.
  Result<std::optional<spi::CipherMask>> required_ciphers(const EntityId& id);
  /// nullptr: never added.
  const spi::EndpointSecurityAttributes* attributes(const EntityId& id) const;

  // Remote participants.
  struct RemoteParticipant {
    spi::IdentityHandle identity;
    spi::PermissionsHandle permissions;
    std::shared_ptr<const spi::SharedSecret> secret;
    /// Plain SEDP and liveliness come inside protected messages too; not so from Cyclone DDS.
    bool wraps_plain_builtin = true;
  };
  Status add_remote(const GuidPrefix& prefix, RemoteParticipant remote);
  void remove_remote(const GuidPrefix& prefix);
  Result<std::vector<spi::Token>> participant_tokens(const GuidPrefix& prefix,
                                                     spi::KeyStage stage = spi::KeyStage::in_use);
  Status set_participant_tokens(const GuidPrefix& prefix, std::span<const spi::Token> tokens);

  // Pairs of a local and a remote endpoint.
  struct Introduction {
    bool ready = false;  ///< keys are there, or none are needed
    bool is_new = false;
    std::vector<spi::Token> tokens = {};  ///< to be sent to the remote endpoint, if new
  };
  /// Registers a pair, or finds it.
  Result<Introduction> introduce(const EntityId& local, const Guid& remote,
                                 bool relay_only = false);
  void part(const EntityId& local, const Guid& remote);
  bool is_introduced(const EntityId& local, const Guid& remote) const;
  /// Stands for the keys that protect what the remote endpoint says to the local one: the same as
  /// long as they are. Nothing: the content is not authenticated.
  std::optional<Sha256Digest> keys_of(const EntityId& local, const Guid& remote) const;
  /// True: the pair has become ready.
  Result<bool> set_endpoint_tokens(const EntityId& local, const Guid& remote,
                                   std::span<const spi::Token> tokens);

  // Key revision (DDS-Security 1.2 9.8.10.4); see spi::CryptoKeyFactory.
  Result<spi::KeyRevision> revise();
  Status activate(spi::KeyRevision revision);
  bool is_revision_due() { return factory().is_key_revision_due(own_.crypto()); }
  void forget_former_keys() { factory().forget_former_keys(); }
  /// Those of our endpoints with those of a peer that have keys of their own.
  std::vector<std::pair<EntityId, Guid>> pairs_with_keys(const GuidPrefix& prefix) const;
  /// What the remote endpoint of such a pair needs, now or of the revision under way.
  Result<std::vector<spi::Token>> endpoint_tokens(const EntityId& local, const Guid& remote,
                                                  spi::KeyStage stage);

  // Receiving. Each writes to `scratch`, which needs as many octets as the input has.
  /// A whole message; one that is not protected, and need not be, as it is. Errors: those of the
  /// plugin, rtps_protection_missing (no pre-shared key where one is due), secure_flags_unsupported
  /// (one where none is); counted, and an event where it is worth one.
  struct OpenMessage {
    BytesView plain;
    bool by_participant = false;  ///< by its sender's own key
  };
  Result<OpenMessage> open_message(const Header& header, BytesView message, MutableBytes scratch,
                                   MonotonicTime now);
  struct OpenSubmessage {
    BytesView plain;
    Guid by;
  };
  Result<OpenSubmessage> open_submessage(const GuidPrefix& sender, BytesView group,
                                         MutableBytes scratch);
  /// `reader` and `writer` must be a ready pair. An unprotected payload passes through.
  Result<BytesView> open_payload(const EntityId& reader, const Guid& writer, BytesView payload,
                                 MutableBytes scratch);
  /// Was it protected as the governance demands? What is refused is counted.
  bool accepts(const EntityId& local, const Guid& remote, const Shield& shield);
  /// The same of a dispose or unregister without a payload, where payloads are all that is
  /// protected and the writer is one that sends the key in them.
  bool accepts_without_payload(const EntityId& local, const Guid& remote, const Shield& shield);
  const ProtectionCounters& counters() const { return counters_; }

  // SendProtection
  Levels levels(const EntityId& sender) const override;
  Result<std::size_t> protect_payload(const EntityId& writer, BytesView plain,
                                      MutableBytes out) override;
  Result<std::size_t> protect_submessage(const EntityId& sender, const Guid& receiver,
                                         BytesView plain, MutableBytes out) override;
  Result<std::size_t> protect_message(Wrap wrap, const GuidPrefix& receiver, BytesView plain,
                                      MutableBytes out) override;
  void on_unprotectable(const Error& error) override;

 private:
  struct Pair {
    std::int64_t handle = 0;  ///< the remote endpoint's; 0: no keys at all
    bool ready = false;
    Sha256Digest keys = {};                 ///< of its tokens, the latest
    std::optional<std::size_t> place = {};  ///< in the lists of ready ones
  };
  struct Local {
    spi::EndpointSecurityAttributes attributes;
    bool is_volatile = false;
    std::int64_t handle = 0;  ///< 0: nothing to protect
    std::map<Guid, Pair> pairs = {};
    std::vector<spi::DatareaderCryptoHandle> readers = {};  ///< a writer's ready ones
    std::vector<spi::DatawriterCryptoHandle> writers = {};  ///< a reader's ready ones
    std::vector<Pair*> ready = {};                          ///< the pairs of either list
    /// Adds a pair to the lists if it is ready, or takes it out, without a look at the others.
    void list(const EntityId& id, Pair& pair);
    void unlist(const EntityId& id, Pair& pair);
  };
  struct Remote {
    spi::ParticipantCryptoHandle crypto;
    std::shared_ptr<const spi::SharedSecret> secret;
    bool wraps_plain_builtin = true;
    Sha256Digest keys = {};  ///< of its tokens, the latest
  };

  const Local* find(const EntityId& id) const;
  Result<std::int64_t> register_pair(const EntityId& id, const Local& local, const Remote& remote,
                                     bool relay_only);
  Result<std::vector<spi::Token>> tokens_for(const EntityId& id, const Local& local,
                                             const Pair& pair,
                                             spi::KeyStage stage = spi::KeyStage::in_use);
  void unregister(const EntityId& id, std::int64_t remote);
  spi::CryptoKeyFactory& factory() { return own_.plugins().cryptography.key_factory(); }
  spi::CryptoKeyExchange& exchange() { return own_.plugins().cryptography.key_exchange(); }
  spi::CryptoTransform& transform() { return own_.plugins().cryptography.transform(); }
  std::unexpected<Error> undecodable(const Error& error, const GuidPrefix& sender);

  OwnSecurity& own_;
  EventSink& events_;
  std::map<EntityId, Local> locals_;
  std::map<GuidPrefix, Remote> remotes_;
  std::vector<spi::ParticipantCryptoHandle> all_remotes_;
  std::unordered_map<std::int64_t, Guid> endpoint_of_;
  ProtectionCounters counters_;
  PreSharedMessages pre_shared_{own_, events_, counters_};
};

}  // namespace ddssec::rtps
