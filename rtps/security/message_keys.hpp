// The keys with which a local participant protects whole messages.
#pragma once

#include <vector>

#include "rtps/reliability/key_age.hpp"
#include "rtps/security/endpoint_keys.hpp"

namespace ddssec::rtps {

/// The protection of messages with participants' keys. While a governance document takes the place
/// of another one (GovernanceTransition), there are two protections, each with keys of its own.
/// Messages with either are opened; the first one protects what is sent. No I/O, clock or lock.
class MessageKeys {
 public:
  /// `remotes`: the remote participants that add_remote may name.
  MessageKeys(OwnSecurity& own, const Remotes& remotes);
  ~MessageKeys();
  MessageKeys(const MessageKeys&) = delete;
  MessageKeys& operator=(const MessageKeys&) = delete;

  /// Names a protection of messages. 0: none is named.
  static ProtectionId id_of(ProtectionKind kind);
  /// The protection of what is sent.
  ProtectionKind kind() const { return first_.kind; }
  ProtectionId id() const { return id_of(first_.kind); }
  /// Number of remote participants that a message to all is for.
  std::size_t receivers() const { return first_.remotes.size(); }

  // Remote participants:
  /// Registers the remote participant with the protection that counts when messages are sent, and
  /// with the second one if it can be. Returns the handle. Errors: those of the plugin.
  Result<spi::ParticipantCryptoHandle> add_remote(const RemoteCrypto& remote);
  void remove_remote(spi::ParticipantCryptoHandle remote);

  // Two protections:
  /// Makes keys for a second protection, unless there are two. `attributes`: those of the
  /// participant that demand it. Errors: those of the plugin.
  Status add_second(const spi::ParticipantSecurityAttributes& attributes);
  bool has_second() const { return second_.has_value(); }
  /// True if messages have this protection now, as the first or the second one.
  bool has(ProtectionId protection) const {
    return protection == id() || (second_ && protection == id_of(second_->kind));
  }
  /// Returns the protection under the new governance document.
  ProtectionId next_id() const { return id_of(next().kind); }
  /// From now on the second protection is the first one, and the other way round.
  void swap() noexcept;
  void remove_second();
  /// Returns the kind of the second protection, or of the first one if there is no second.
  ProtectionKind second_kind() const { return second_ ? second_->kind : first_.kind; }

  // Tokens:
  /// Returns the tokens that the remote participant needs for a protection; 0 means the one that
  /// is used for sending.
  /// Errors: crypto_not_matched, those of the plugin.
  Result<std::vector<spi::Token>> tokens(spi::ParticipantCryptoHandle remote, ProtectionId of = 0,
                                         spi::KeyStage stage = spi::KeyStage::in_use);
  /// Sets the remote participant's tokens for a protection; 0 means whichever they fit. Errors:
  /// those of the plugin.
  Status set_tokens(spi::ParticipantCryptoHandle remote, std::span<const spi::Token> tokens,
                    ProtectionId of = 0);

  // Key revision; see Keyring:
  /// Makes the next keys of messages, also those of a second protection. Errors: those of the
  /// plugin.
  Status revise();
  Status activate();
  bool needs_revision();

  // Messages. Errors: those of the plugin.
  /// `receiver`: nullptr: all remote participants.
  Result<std::size_t> protect(const spi::ParticipantCryptoHandle* receiver, BytesView plain,
                              MutableBytes out);
  struct OpenResult {
    std::size_t size;
    KeyAge age;
  };
  /// `says_next` is true if the sender no longer uses the former one of two protections. Error
  /// then: message_from_before.
  Result<OpenResult> open(spi::ParticipantCryptoHandle sender, BytesView message,
                          MutableBytes scratch, bool says_next);

 private:
  struct Protection {
    spi::ParticipantCryptoHandle handle;  ///< of the local participant
    ProtectionKind kind;
    std::vector<spi::ParticipantCryptoHandle> remotes = {};
    /// The revisions of the newest keys of remote participants, by their handles.
    std::map<std::int64_t, spi::KeyRevision> revisions = {};
    /// While its keys are being revised apart from those of the endpoints.
    std::optional<spi::KeyRevision> revision = {};
  };
  Result<spi::ParticipantCryptoHandle> add_remote(Protection& to, const RemoteCrypto& remote);
  Status revise(Protection& protection);
  Status activate(Protection& protection);
  void release(const Protection& protection);
  Result<OpenResult> open(const Protection& protection, spi::ParticipantCryptoHandle sender,
                          BytesView message, MutableBytes scratch);
  /// Returns the protection under the new governance document.
  const Protection& next() const { return has_swapped_ || !second_ ? first_ : *second_; }
  spi::CryptoKeyFactory& factory() { return own_.plugins().cryptography.key_factory(); }

  OwnSecurity& own_;
  const Remotes& remotes_;
  Protection first_;
  std::optional<Protection> second_;
  bool has_swapped_ = false;
};

}  // namespace ddssec::rtps
