#include "rtps/security/message_keys.hpp"

#include <algorithm>

#include "plugins/spi/named_key_revision.hpp"
#include "wire/header.hpp"

namespace ddssec::rtps {
namespace {

// The message was not for this key: its sender may have used that of the other protection.
bool is_of_other_key(Code code) {
  return code == Code::not_protected || code == Code::key_material_not_received ||
         code == Code::encrypted_where_signature_is_due ||
         code == Code::signed_where_encryption_is_due || code == Code::transform_kind_mismatch ||
         code == Code::transform_key_id_mismatch || code == Code::receiver_specific_mac_missing ||
         code == Code::key_revision_unknown;
}

}  // namespace

MessageKeys::MessageKeys(OwnSecurity& own, const Remotes& remotes)
    : own_(own), remotes_(remotes), first_{own.crypto(), own.attributes().rtps} {}

MessageKeys::~MessageKeys() {
  remove_second();
  release(first_);
}

// The participant's own handle stays, because its endpoints belong to it.
void MessageKeys::release(const Protection& protection) {
  if (protection.handle != own_.crypto())
    static_cast<void>(factory().unregister_participant(protection.handle));
}

ProtectionId MessageKeys::id_of(ProtectionKind kind) {
  spi::ParticipantSecurityAttributes attributes;
  attributes.rtps = kind;
  const auto info = spi::security_info(attributes);
  return ProtectionId{info.mask} << 32 | info.plugin_mask;
}

// ---- remote participants

Result<spi::ParticipantCryptoHandle> MessageKeys::add_remote(Protection& to,
                                                             const RemoteCrypto& remote) {
  DDSSEC_ASSIGN_OR_RETURN(const auto handle,
                          factory().register_matched_remote_participant(
                              to.handle, remote.identity, remote.permissions, *remote.secret));
  if (std::ranges::find(to.remotes, handle) == to.remotes.end()) to.remotes.push_back(handle);
  return handle;
}

// The keys of endpoints need it to be registered for the participant's own handle, too.
Result<spi::ParticipantCryptoHandle> MessageKeys::add_remote(const RemoteCrypto& remote) {
  DDSSEC_ASSIGN_OR_RETURN(const auto handle,
                          factory().register_matched_remote_participant(
                              own_.crypto(), remote.identity, remote.permissions, *remote.secret));
  if (const auto added = add_remote(first_, remote); !added) {
    static_cast<void>(factory().unregister_participant(handle));
    return added;
  }
  if (second_) static_cast<void>(add_remote(*second_, remote));
  return handle;
}

void MessageKeys::remove_remote(spi::ParticipantCryptoHandle remote) {
  for (auto* protection : {&first_, second_ ? &*second_ : nullptr}) {
    if (protection == nullptr) continue;
    std::erase(protection->remotes, remote);
    protection->revisions.erase(remote.value);
  }
}

// ---- two protections

Status MessageKeys::add_second(const spi::ParticipantSecurityAttributes& attributes) {
  if (second_) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto handle,
                          factory().register_local_participant(own_.identity(), own_.permissions(),
                                                               own_.properties(), attributes));
  second_ = Protection{handle, attributes.rtps};
  has_swapped_ = false;
  for (const auto& [prefix, remote] : remotes_) static_cast<void>(add_remote(*second_, remote));
  return {};
}

void MessageKeys::swap() noexcept {
  if (!second_) return;
  std::swap(first_, *second_);
  has_swapped_ = true;
}

void MessageKeys::remove_second() {
  if (second_) release(*second_);
  second_.reset();
  has_swapped_ = false;
}

// ---- tokens

Result<std::vector<spi::Token>> MessageKeys::tokens(spi::ParticipantCryptoHandle remote,
                                                    ProtectionId of, spi::KeyStage stage) {
  const bool is_of_second = of != 0 && of != id() && second_ && id_of(second_->kind) == of;
  const auto& protection = is_of_second ? *second_ : first_;
  return own_.plugins().cryptography.key_exchange().create_local_participant_crypto_tokens(
      protection.handle, remote, stage);
}

Status MessageKeys::set_tokens(spi::ParticipantCryptoHandle remote,
                               std::span<const spi::Token> tokens, ProtectionId of) {
  auto& exchange = own_.plugins().cryptography.key_exchange();
  const auto set = [&](Protection& protection) -> Status {
    DDSSEC_RETURN_IF_ERROR(
        exchange.set_remote_participant_crypto_tokens(protection.handle, remote, tokens));
    protection.revisions[remote.value] = exchange.key_revision_of(tokens);
    return {};
  };
  const bool fits_first = of == 0 || of == id();
  const bool fits_second = second_ && (of == 0 || of == id_of(second_->kind));
  if (!fits_first) return fits_second ? set(*second_) : fail(Code::crypto_tokens_not_expected);
  const auto first = set(first_);
  if (!fits_second) return first;
  const auto second = set(*second_);
  return first || second ? Status() : first;
}

// ---- key revision

// The keys of the participant's own handle are revised with those of its endpoints.
Status MessageKeys::revise(Protection& protection) {
  if (protection.handle == own_.crypto() || protection.revision) return {};
  DDSSEC_ASSIGN_OR_RETURN(protection.revision,
                          factory().revise_local_entity_keys(protection.handle));
  return {};
}

Status MessageKeys::activate(Protection& protection) {
  const auto revision = std::exchange(protection.revision, std::nullopt);
  return revision ? factory().activate_key_revision(protection.handle, *revision) : Status();
}

Status MessageKeys::revise() {
  DDSSEC_RETURN_IF_ERROR(revise(first_));
  return second_ ? revise(*second_) : Status();
}

Status MessageKeys::activate() {
  const auto first = activate(first_);
  const auto second = second_ ? activate(*second_) : Status();
  return first ? second : first;
}

bool MessageKeys::needs_revision() {
  return first_.handle != own_.crypto() && factory().is_key_revision_due(first_.handle);
}

// ---- messages

Result<std::size_t> MessageKeys::protect(const spi::ParticipantCryptoHandle* receiver,
                                         BytesView plain, MutableBytes out) {
  const auto receivers =
      receiver == nullptr ? std::span(std::as_const(first_.remotes)) : std::span(receiver, 1);
  return own_.plugins().cryptography.transform().encode_rtps_message(first_.handle, receivers,
                                                                     plain, out);
}

Result<MessageKeys::OpenResult> MessageKeys::open(const Protection& protection,
                                                  spi::ParticipantCryptoHandle sender,
                                                  BytesView message, MutableBytes scratch) {
  DDSSEC_ASSIGN_OR_RETURN(const auto size,
                          own_.plugins().cryptography.transform().decode_rtps_message(
                              protection.handle, sender, message, scratch));
  const auto newest = protection.revisions.find(sender.value);
  const bool is_newest = newest != protection.revisions.end() &&
                         newest->second == spi::named_key_revision(message.subspan(kHeaderSize));
  return OpenResult{size, is_newest ? KeyAge::newest : KeyAge::former};
}

Result<MessageKeys::OpenResult> MessageKeys::open(spi::ParticipantCryptoHandle sender,
                                                  BytesView message, MutableBytes scratch,
                                                  bool says_next) {
  const auto& expected = says_next ? next() : first_;
  auto opened = open(expected, sender, message, scratch);
  if (opened || !second_) [[likely]]
    return opened;
  if (!is_of_other_key(opened.error().code())) return opened;
  if (says_next) return fail(Code::message_from_before);
  return open(*second_, sender, message, scratch);
}

}  // namespace ddssec::rtps
