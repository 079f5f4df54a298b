#include "plugins/cryptography/pre_shared_key.hpp"

#include <algorithm>
#include <string>

#include "base/hash.hpp"
#include "plugins/cryptography/cipher_choice.hpp"
#include "plugins/cryptography/key_factory.hpp"
#include "plugins/spi/files_poll_interval.hpp"

namespace ddssec::cryptography {
namespace {

// Computes HKDF-Extract and one block of HKDF-Expand (RFC 5869), with the sender as the salt.
template <class Key>
Key derive(std::string_view label, std::string_view info, const Passphrase& passphrase,
           BytesView context, std::size_t size) {
  Bytes salt = to_bytes(as_bytes(label));
  salt.insert(salt.end(), context.begin(), context.end());
  auto extracted =
      passphrase.text.expose([&](BytesView text) { return hmac_sha256(salt, {text}); });
  constexpr std::uint8_t kFirstBlock[] = {1};
  auto expanded = hmac_sha256(extracted, {as_bytes(info), kFirstBlock});
  auto key = Key::copy_of(BytesView(expanded).first(size));
  wipe(extracted);
  wipe(expanded);
  return std::move(*key);
}

MessageSource source_of(BytesView message) {
  MessageSource source;
  std::ranges::copy(message.subspan(4, source.size()), source.begin());
  return source;
}

bool is_message(BytesView octets) {
  return octets.size() >= kRtpsHeaderSize && as_text(octets.first(4)) == "RTPS";
}

}  // namespace

KeyId pre_shared_key_id(std::uint32_t passphrase_id, DomainId domain_id,
                        std::string_view domain_tag) {
  const auto domain = std::to_string(domain_id);
  const auto digest = sha256(
      {as_bytes("DomainId="), as_bytes(domain), as_bytes(";DomainTag="), as_bytes(domain_tag)});
  return {{digest[0], digest[1], digest[2], static_cast<std::uint8_t>(passphrase_id)}};
}

TransformKind pre_shared_kind(TransformKind algorithm, std::uint32_t passphrase_id) {
  const auto octet = [&](unsigned shift) {
    return static_cast<std::uint8_t>(passphrase_id >> shift);
  };
  return {{octet(24), octet(16), octet(8), algorithm.octets[3]}};
}

KeyMaterial derive_pre_shared_material(const Passphrase& passphrase, TransformKind kind,
                                       KeyId key_id, const MessageSource& source) {
  Bytes context = to_bytes(key_id.view());
  for (const auto part : {as_bytes("RTPS"), BytesView(source)})
    context.insert(context.end(), part.begin(), part.end());
  const auto size = traits_of(kind)->key_size();
  KeyMaterial material{.kind = kind};
  material.sender_key_id = key_id;
  material.salt =
      derive<MasterSalt>("PSK-SALT", "master salt derivation", passphrase, context, size);
  material.sender_key =
      derive<MasterKey>("PSK-SKEY", "master sender key derivation", passphrase, context, size);
  return material;
}

Result<std::unique_ptr<PreSharedKeyRing>> PreSharedKeyRing::create(PassphraseFiles files,
                                                                   Domain domain,
                                                                   const PluginServices& services,
                                                                   const KeyServices& keys) {
  DDSSEC_ASSIGN_OR_RETURN(auto passphrases, files.load(services.events));
  std::unique_ptr<PreSharedKeyRing> out(
      new PreSharedKeyRing(std::move(files), std::move(domain), services, keys));
  out->use(std::move(passphrases));
  return out;
}

void PreSharedKeyRing::use(std::vector<Passphrase> passphrases) {
  if (!entries_.empty() && passphrases.front() != entries_.front().passphrase) send_.reset();
  std::erase_if(senders_, [&](const auto& sender) {
    const auto id = sender.first.passphrase_id;
    const auto is_its = [&](const Passphrase& passphrase) { return passphrase.id == id; };
    const auto now = std::ranges::find_if(passphrases, is_its);
    return now == passphrases.end() ||
           std::ranges::find_if(entries_, is_its, &Entry::passphrase)->passphrase != *now;
  });
  entries_.clear();
  for (auto& passphrase : passphrases) {
    const auto kind = pre_shared_kind(domain_.algorithm, passphrase.id);
    const auto key_id = pre_shared_key_id(passphrase.id, domain_.id, domain_.tag);
    entries_.push_back({std::move(passphrase), kind, key_id});
  }
}

bool PreSharedKeyRing::uses(const std::vector<Passphrase>& passphrases) const {
  return std::ranges::equal(entries_, passphrases, {}, &Entry::passphrase);
}

// Unusable passphrases change nothing. The files are read again every time, because the cause may
// have been temporary. It is reported once.
void PreSharedKeyRing::refresh() {
  if (!files_.may_have_changed(services_.clock.monotonic())) return;
  auto passphrases = files_.load(services_.events);
  if (!passphrases) return keep_despite(passphrases.error());
  complaint_.clear();
  if (uses(*passphrases)) return;
  use(std::move(*passphrases));
  std::string understood;
  for (const auto& entry : entries_)
    understood += (understood.empty() ? "" : ", ") + std::to_string(entry.passphrase.id);
  services_.events.raise(Event(Error(Code::psk_passphrases_changed,
                                     {.found = std::to_string(entries_.front().passphrase.id) +
                                               " to send with, understood are " + understood}),
                               {}, {}, PeerProof::not_a_peer));
}

void PreSharedKeyRing::keep_despite(const Error& error) {
  files_.force_change();
  auto details = error.details();
  details.document = files_.place_of(details.document);
  details.note =
      std::string(info(error.code()).summary) + (details.note.empty() ? "" : ": " + details.note);
  const Error complaint(Code::psk_passphrases_kept, std::move(details));
  const auto before = std::exchange(complaint_, complaint.to_sentence());
  if (complaint_ != before) services_.events.raise(Event(complaint));
}

// A participant has the same source for its whole life. After a restart with the same source it has
// the same master key, so random starts keep its IVs apart.
Result<SendKey*> PreSharedKeyRing::send_key(const MessageSource& source) {
  if (send_ && source == own_) return send_.get();
  const auto& entry = entries_.front();
  DDSSEC_ASSIGN_OR_RETURN(const auto start, SendStart::draw(services_.random));
  DDSSEC_ASSIGN_OR_RETURN(
      send_, SendKey::create(
                 derive_pre_shared_material(entry.passphrase, entry.kind, entry.key_id, source),
                 start, keys_));
  own_ = source;
  return send_.get();
}

Result<std::size_t> PreSharedKeyRing::encode(BytesView plain, MutableBytes out) {
  if (!is_message(plain)) return fail(Code::plaintext_malformed);
  DDSSEC_ASSIGN_OR_RETURN(auto* const key, send_key(source_of(plain)));
  const ReadGuard guard;
  return seal_message(plain, kPreSharedKeyFrame, *key, out);
}

// Compares only the key revision, which is part of the passphrase's id. The rest of the kind is
// checked with the key.
Result<const PreSharedKeyRing::Entry*> PreSharedKeyRing::entry_of(BytesView encoded) const {
  if (!is_message(encoded)) return fail(Code::secure_group_malformed);
  DDSSEC_ASSIGN_OR_RETURN(const auto header,
                          read_prefix(encoded.subspan(kRtpsHeaderSize), kPreSharedKeyFrame));
  const auto revision = BytesView(header.kind.octets).first(3);
  const auto at = std::ranges::find_if(entries_, [&](const Entry& entry) {
    return entry.key_id == header.key_id &&
           std::ranges::equal(revision, BytesView(entry.kind.octets).first(3));
  });
  if (at != entries_.end()) return &*at;
  const auto& octets = header.kind.octets;
  const auto id = std::uint32_t{octets[0]} << 24 | std::uint32_t{octets[1]} << 16 |
                  std::uint32_t{octets[2]} << 8 | header.key_id.octets[3];
  return fail(Code::psk_passphrase_unknown,
              {.field = "pre-shared key of passphrase " + std::to_string(id),
               .expected = entries_.front().key_id.to_string(),
               .found = header.key_id.to_string()});
}

bool PreSharedKeyRing::remembers(BytesView encoded) const {
  const auto entry = entry_of(encoded);
  return entry && senders_.contains({source_of(encoded), (*entry)->passphrase.id});
}

Result<std::size_t> PreSharedKeyRing::decode(BytesView encoded, MutableBytes out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto found_entry, entry_of(encoded));
  const auto& entry = *found_entry;
  const SenderId id{source_of(encoded), entry.passphrase.id};
  const ReadGuard guard;
  const auto known = senders_.find(id);
  if (known == senders_.end()) return open_first(id, entry, encoded, out);
  known->second.last_used = ++time_;
  return open_message(encoded, kPreSharedKeyFrame, *known->second.key, out);
}

Result<std::size_t> PreSharedKeyRing::open_first(const SenderId& id, const Entry& entry,
                                                 BytesView encoded, MutableBytes out) {
  auto key = std::make_unique<ReceiveKey>(
      derive_pre_shared_material(entry.passphrase, entry.kind, entry.key_id, id.source),
      *traits_of(entry.kind), keys_);
  DDSSEC_ASSIGN_OR_RETURN(const auto size, open_message(encoded, kPreSharedKeyFrame, *key, out));
  remember(id, std::move(key));
  return size;
}

void PreSharedKeyRing::remember(const SenderId& id, std::unique_ptr<ReceiveKey> key) {
  if (senders_.size() >= kMaxSenders)
    senders_.erase(std::ranges::min_element(
        senders_, {}, [](const auto& entry) { return entry.second.last_used; }));
  senders_.emplace(id, Sender{std::move(key), ++time_});
}

Result<std::unique_ptr<spi::PreSharedKeys>> KeyFactory::pre_shared_keys(
    const spi::PreSharedKeyRequest& request) {
  const auto kind = request.attributes.rtps_psk;
  if (!is_protected(kind)) return fail(Code::not_protected);
  DDSSEC_ASSIGN_OR_RETURN(const auto cipher, pre_shared_cipher(request.properties));
  DDSSEC_RETURN_IF_ERROR(check_cipher(cipher, request.attributes.allowed_ciphers));
  DDSSEC_ASSIGN_OR_RETURN(const auto files_poll_interval,
                          spi::files_poll_interval(request.properties));
  PassphraseFiles files(request.properties, files_poll_interval);
  DDSSEC_ASSIGN_OR_RETURN(
      auto pre_shared_key_ring,
      PreSharedKeyRing::create(std::move(files),
                               {request.domain_id, std::string(request.domain_tag),
                                kind_for(cipher, is_encrypted(kind))},
                               state_.services, state_.keys));
  return pre_shared_key_ring;
}

}  // namespace ddssec::cryptography
