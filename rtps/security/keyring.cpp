#include "rtps/security/keyring.hpp"

#include <algorithm>

#include "plugins/spi/property_names.hpp"

namespace ddssec::rtps {
Keyring::~Keyring() {
  while (!remotes_.empty()) remove_remote(remotes_.begin()->first);
  while (!locals_.empty()) remove_local(EntityId(locals_.begin()->first));
}

const spi::EndpointSecurityAttributes* Keyring::attributes(const EntityId& id) const {
  const auto* local = find(id);
  return local == nullptr ? nullptr : &local->attributes;
}

// ---- local endpoints

Status Keyring::add_local(const EntityId& id, const spi::EndpointSecurityAttributes& attributes,
                          std::string_view builtin_name, spi::PropertyList properties) {
  LocalKeys local{attributes, !builtin_name.empty()};
  if (local.is_volatile)
    properties.push_back(
        {std::string(spi::property::kBuiltinEndpointName), std::string(builtin_name), false});
  local.properties = std::move(properties);
  return keys_.add(locals_, id, std::move(local));
}

Result<std::optional<spi::CipherMask>> Keyring::required_ciphers(const EntityId& id) {
  const auto* local = find(id);
  if (local == nullptr || local->handle == 0) return std::nullopt;
  if (is_writer(id)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto ciphers,
                            factory().required_ciphers(spi::DatawriterCryptoHandle{local->handle}));
    return ciphers;
  }
  // A reader sends nothing with a payload key.
  if (!local->attributes.is_submessage_protected()) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto ciphers,
                          factory().required_ciphers(spi::DatareaderCryptoHandle{local->handle}));
  return ciphers;
}

void Keyring::remove_local(const EntityId& id) {
  phases_.endpoints().remove(id);
  keys_.remove(locals_, id);
}

// ---- remote participants

Status Keyring::add_remote(const GuidPrefix& prefix, RemoteRegistration remote) {
  RemoteCrypto crypto{.identity = remote.identity,
                      .permissions = remote.permissions,
                      .secret = std::move(remote.secret),
                      .wraps_plain_builtin = remote.wraps_plain_builtin,
                      .answers_key_requests = remote.answers_key_requests,
                      .sends_next = phases_.has_swapped()};
  DDSSEC_ASSIGN_OR_RETURN(crypto.crypto, phases_.messages().add_remote(crypto));
  own_.session_ends().expect(prefix, *crypto.secret);
  remotes_[prefix] = std::move(crypto);
  return {};
}

void Keyring::remove_remote(const GuidPrefix& prefix) {
  phases_.endpoints().unregister_pairs_of(prefix);
  keys_.unregister_pairs_of(locals_, prefix);
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return;
  own_.session_ends().forget(prefix);
  phases_.messages().remove_remote(at->second.crypto);
  static_cast<void>(factory().unregister_participant(at->second.crypto));
  remotes_.erase(at);
}

Result<std::vector<spi::Token>> Keyring::participant_tokens(const GuidPrefix& prefix,
                                                            ProtectionId protection,
                                                            spi::KeyStage stage) {
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return fail(Code::crypto_not_matched);
  return phases_.messages().tokens(at->second.crypto, protection, stage);
}

Result<bool> Keyring::set_participant_tokens(const GuidPrefix& prefix,
                                             std::span<const spi::Token> tokens,
                                             ProtectionId protection) {
  const auto at = remotes_.find(prefix);
  if (at == remotes_.end()) return fail(Code::crypto_not_matched);
  DDSSEC_RETURN_IF_ERROR(phases_.messages().set_tokens(at->second.crypto, tokens, protection));
  auto& known = at->second.keys[protection != 0 ? protection : phases_.messages().id()];
  const auto former = std::exchange(known, exchange().digest_of(tokens));
  return former != Sha256Digest{} && former != known;
}

// ---- pairs

Result<PairRegistration> Keyring::register_pair(const EntityId& id, const Guid& remote,
                                                bool is_relay_only) {
  const auto at = locals_.find(id);
  if (at == locals_.end()) return fail(Code::crypto_not_matched);
  const bool is_second_doubtful = phases_.endpoints().resume(id, remote, is_relay_only);
  auto& local = at->second;
  if (const auto known = local.pairs.find(remote); known != local.pairs.end()) {
    auto& pair = known->second;
    if (pair.is_relay_only == is_relay_only && !pair.is_suspended) {
      pair.is_silent = false;
      local.list(id, remote, pair);
      return PairRegistration{.is_ready = pair.is_ready};
    }
    if (pair.is_relay_only == is_relay_only) {
      // The remote endpoint gets the keys again: they may have been revised.
      DDSSEC_ASSIGN_OR_RETURN(auto tokens, keys_.tokens_for(id, local, pair));
      keys_.resume(id, local, remote, pair);
      phases_.endpoints().drop_keys(id, local.note_idle(remote, pair));
      return PairRegistration{pair.is_ready, true, pair.are_keys_doubtful || is_second_doubtful,
                              std::move(tokens)};
    }
    unregister_pair(id, remote);
  }
  DDSSEC_ASSIGN_OR_RETURN(auto registered, keys_.register_pair(id, local, remote, is_relay_only));
  phases_.endpoints().drop_keys(id, registered.displaced);
  registered.are_keys_doubtful = is_second_doubtful;
  return registered;
}

// The remote endpoint sends its keys for either protection only once, so both stay or go.
std::optional<Guid> Keyring::unregister_pair(const EntityId& id, const Guid& remote,
                                             AfterMatch after) {
  phases_.endpoints().unregister_pair(id, remote, after);
  auto displaced = keys_.unregister_pair(locals_, id, remote, after);
  phases_.endpoints().drop_keys(id, displaced);
  return displaced;
}

Keyring::PairKind Keyring::kind_of(const EntityId& id, const Guid& remote) const {
  const auto* local = find(id);
  if (local == nullptr) return PairKind::unknown;
  const auto pair = local->pairs.find(remote);
  if (pair == local->pairs.end()) return PairKind::unknown;
  if (pair->second.is_suspended) return PairKind::suspended;
  return pair->second.is_relay_only ? PairKind::relay_only : PairKind::ordinary;
}

bool Keyring::is_pair_registered(const EntityId& id, const Guid& remote) const {
  const auto kind = kind_of(id, remote);
  return kind == PairKind::ordinary || kind == PairKind::relay_only;
}

Keyring::PairKeyState Keyring::keys_for(const EntityId& id, const Guid& remote) const {
  const auto* local = find(id);
  if (local == nullptr) return {};
  PairKeyState out{.may_be_dropped = local->idle.has_displaced(remote.prefix)};
  if (const auto* second = phases_.endpoints().second_keys_of(id, remote)) {
    const auto& pair = second->pairs.at(remote);
    out.have_second_come = pair.keys != Sha256Digest{};
    out.are_second_awaited = !phases_.has_swapped() && !pair.is_ready && !pair.is_suspended;
    out.may_be_dropped = out.may_be_dropped || second->idle.has_displaced(remote.prefix);
  }
  const auto found = local->pairs.find(remote);
  if (found == local->pairs.end()) return out;
  const auto& pair = found->second;
  out.have_come = pair.keys != Sha256Digest{};
  out.are_awaited = !pair.is_ready && !pair.is_suspended;
  return out;
}

// There is no digest if only payloads are protected: an attacker can change their sequence numbers.
std::optional<Sha256Digest> Keyring::keys_of(const EntityId& id, const Guid& remote) const {
  const auto* local = phases_.demanded(id, remote);
  const auto peer = remotes_.find(remote.prefix);
  if (local == nullptr || peer == remotes_.end()) return std::nullopt;
  const bool by_message = phases_.must_protect_messages(remote.prefix);
  const bool by_submessage = local->attributes.is_submessage_protected();
  if (by_submessage && !local->pairs.contains(remote)) return std::nullopt;
  if (!by_message && !by_submessage) return std::nullopt;
  const Sha256Digest none{};
  return sha256({by_message ? phases_.message_keys_of(remote.prefix) : none,
                 by_submessage ? local->pairs.at(remote).keys : none});
}

Result<bool> Keyring::set_endpoint_tokens(const EntityId& id, const Guid& remote,
                                          std::span<const spi::Token> tokens,
                                          ProtectionId protection) {
  auto* local = phases_.endpoints().find(id, protection);
  if (local == nullptr) return fail(Code::crypto_not_matched);
  const bool is_first = local == find(id);
  const auto pair = local->pairs.find(remote);
  if (pair == local->pairs.end() || pair->second.handle == 0)
    return fail(Code::crypto_tokens_not_expected);
  const auto own = local->handle;
  const auto peer = pair->second.handle;
  if (is_writer(id))
    DDSSEC_RETURN_IF_ERROR(exchange().set_remote_datareader_crypto_tokens({own}, {peer}, tokens));
  else
    DDSSEC_RETURN_IF_ERROR(exchange().set_remote_datawriter_crypto_tokens({own}, {peer}, tokens));
  pair->second.keys = exchange().digest_of(tokens);
  keys_.note_revision(peer, exchange().key_revision_of(tokens));
  if (!pair->second.is_suspended) pair->second.are_keys_doubtful = false;
  const bool was_ready = std::exchange(pair->second.is_ready, true);
  local->list(id, remote, pair->second);
  phases_.endpoints().drop_keys(id, local->note_idle(remote, pair->second));
  return is_first && !was_ready && !pair->second.is_suspended;
}

// ---- key revision

Result<spi::KeyRevision> Keyring::revise() {
  DDSSEC_RETURN_IF_ERROR(phases_.messages().revise());
  return factory().revise_local_entity_keys(own_.crypto());
}

Status Keyring::activate(spi::KeyRevision revision) {
  DDSSEC_RETURN_IF_ERROR(phases_.messages().activate());
  return factory().activate_key_revision(own_.crypto(), revision);
}

std::set<std::pair<EntityId, Guid>> Keyring::pairs_with_keys(const GuidPrefix& prefix) const {
  std::set<std::pair<EntityId, Guid>> out;
  for (const auto& [id, local] : locals_) {
    if (local.is_volatile) continue;
    for (auto at = local.pairs.lower_bound({prefix, {}}); at != local.pairs.end(); ++at) {
      if (at->first.prefix != prefix) break;
      if (at->second.handle != 0 && !at->second.is_suspended) out.emplace(id, at->first);
    }
  }
  phases_.endpoints().add_pairs_with_keys(prefix, out);
  return out;
}

Result<std::vector<spi::Token>> Keyring::endpoint_tokens(const EntityId& id, const Guid& remote,
                                                         spi::KeyStage stage) {
  const auto* local = find(id);
  const bool known = local != nullptr && local->pairs.contains(remote);
  if (!known) return fail(Code::crypto_not_matched);
  const auto& pair = local->pairs.at(remote);
  if (local->is_volatile || pair.handle == 0) return std::vector<spi::Token>{};
  return keys_.tokens_for(id, *local, pair, stage);
}

}  // namespace ddssec::rtps
