// Protection of messages by a key that a whole domain shares (DDS-Security 1.2, clause 10.5.2.1.3).
#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "base/clock.hpp"
#include "base/plugin_services.hpp"
#include "plugins/cryptography/message.hpp"
#include "plugins/cryptography/passphrase.hpp"
#include "plugins/spi/pre_shared_key.hpp"

namespace ddssec::cryptography {

/// Version, vendor and GUID prefix, as in an RTPS header.
using MessageSource = std::array<std::uint8_t, 16>;

/// Returns the SenderKeyId: three octets that depend on the domain, and the low octet of the
/// passphrase's id.
KeyId pre_shared_key_id(std::uint32_t passphrase_id, DomainId domain_id,
                        std::string_view domain_tag);

/// Returns `algorithm` with the other three octets of the passphrase's id as its key revision.
TransformKind pre_shared_kind(TransformKind algorithm, std::uint32_t passphrase_id);

/// Returns the keys of one sender. `kind` and `key_id` come from the two functions above.
KeyMaterial derive_pre_shared_material(const Passphrase& passphrase, TransformKind kind,
                                       KeyId key_id, const MessageSource& source);

/// The passphrases and the keys derived from them. A sender's keys are remembered only after a tag
/// under them was right, so a sender without a passphrase takes no memory. Not thread-safe.
class PreSharedKeyRing final : public spi::PreSharedKeys {
 public:
  static constexpr std::size_t kMaxSenders = 1024;

  struct Domain {
    DomainId id;
    std::string tag;
    TransformKind algorithm;
  };
  /// Reads the passphrases. `services` and `keys` must outlive the result. Errors: those of
  /// PassphraseFiles::load.
  static Result<std::unique_ptr<PreSharedKeyRing>> create(PassphraseFiles files, Domain domain,
                                                          const PluginServices& services,
                                                          const KeyServices& keys);

  Result<std::size_t> encode(BytesView plain, MutableBytes out) override;
  bool remembers(BytesView encoded) const override;
  Result<std::size_t> decode(BytesView encoded, MutableBytes out) override;
  void refresh() override;

 private:
  struct Entry {
    Passphrase passphrase;
    TransformKind kind;
    KeyId key_id;
  };
  /// A sender under one passphrase.
  struct SenderId {
    MessageSource source;
    std::uint32_t passphrase_id;
    auto operator<=>(const SenderId&) const = default;
  };
  struct Sender {
    std::unique_ptr<ReceiveKey> key;
    std::uint64_t last_used;
  };

  PreSharedKeyRing(PassphraseFiles files, Domain domain, const PluginServices& services,
                   const KeyServices& keys)
      : files_(std::move(files)), domain_(std::move(domain)), services_(services), keys_(keys) {}
  /// Uses these passphrases: at least one, the first to send with. Drops keys derived from others.
  void use(std::vector<Passphrase> passphrases);
  bool uses(const std::vector<Passphrase>& passphrases) const;
  void keep_despite(const Error& error);
  Result<SendKey*> send_key(const MessageSource& source);
  Result<const Entry*> entry_of(BytesView encoded) const;
  Result<std::size_t> open_first(const SenderId& id, const Entry& entry, BytesView encoded,
                                 MutableBytes out);
  void remember(const SenderId& id, std::unique_ptr<ReceiveKey> key);

  PassphraseFiles files_;
  const Domain domain_;
  const PluginServices& services_;
  const KeyServices& keys_;
  std::vector<Entry> entries_;
  /// The last event about unusable passphrases, to report it once; empty if there is none.
  std::string complaint_;
  MessageSource own_{};
  std::unique_ptr<SendKey> send_;
  std::map<SenderId, Sender> senders_;
  std::uint64_t time_ = 0;
};

}  // namespace ddssec::cryptography
