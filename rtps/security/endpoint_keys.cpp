#include "rtps/security/endpoint_keys.hpp"

#include <algorithm>

#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

bool needs_keys(const spi::EndpointSecurityAttributes& attributes) {
  return attributes.is_submessage_protected() || attributes.is_payload_protected();
}

// A writer needs no tokens of a reader that only opens payloads (Cyclone DDS sends none then). A
// reader needs the writer's keys for either kind of protection.
bool waits_for_tokens(const EntityId& local, const spi::EndpointSecurityAttributes& attributes) {
  return is_writer(local) ? attributes.is_submessage_protected() : needs_keys(attributes);
}

}  // namespace

ProtectionId protection_id(const spi::EndpointSecurityAttributes& attributes) {
  const auto info = spi::security_info(attributes);
  return ProtectionId{info.mask} << 32 | info.plugin_mask;
}

const LocalKeys* find(const Locals& locals, const EntityId& id) {
  const auto at = locals.find(id);
  return at == locals.end() ? nullptr : &at->second;
}

void LocalKeys::list(const EntityId& id, const Guid& remote, PairKeys& pair) {
  const bool is_used = pair.is_ready && pair.handle != 0 && !pair.is_suspended && !pair.is_silent;
  if (!is_used || pair.place) return;
  idle.remove(remote);
  pair.place = ready_pairs.size();
  ready_pairs.push_back(&pair);
  if (is_writer(id))
    readers.push_back({pair.handle});
  else
    writers.push_back({pair.handle});
}

// The last pair moves to the free place.
void LocalKeys::unlist(const EntityId& id, PairKeys& pair) {
  if (!pair.place) return;
  const auto place = *pair.place;
  const auto remove = [place](auto& from) {
    from[place] = from.back();
    from.pop_back();
  };
  ready_pairs.back()->place = place;
  remove(ready_pairs);
  pair.place.reset();
  if (is_writer(id))
    remove(readers);
  else
    remove(writers);
}

// A pair with a reader that sends no keys counts as keys_awaited: if it is given up, nothing is
// lost that only the reader could send again.
std::optional<Guid> LocalKeys::note_idle(const Guid& remote, const PairKeys& pair) {
  if (pair.handle == 0 || pair.place || is_volatile) return std::nullopt;
  const bool have_come = pair.keys != Sha256Digest{};
  return idle.add(remote, pair.is_silent ? IdlePairs::IdleReason::silent
                          : have_come    ? IdlePairs::IdleReason::suspended
                                         : IdlePairs::IdleReason::keys_awaited);
}

std::optional<Sha256Digest> LocalKeys::submessage_tokens_of(const Guid& remote) const {
  const auto pair = pairs.find(remote);
  const bool any = attributes.is_submessage_protected() && pair != pairs.end() &&
                   pair->second.keys != Sha256Digest{};
  return any ? std::optional(pair->second.keys) : std::nullopt;
}

// ---- local endpoints

Status EndpointKeys::register_local(const EntityId& id, LocalKeys& local) {
  if (!needs_keys(local.attributes)) return {};
  if (is_writer(id)) {
    DDSSEC_ASSIGN_OR_RETURN(
        const auto writer,
        factory().register_local_datawriter(own_.crypto(), local.properties, local.attributes));
    local.handle = writer.value;
  } else {
    DDSSEC_ASSIGN_OR_RETURN(
        const auto reader,
        factory().register_local_datareader(own_.crypto(), local.properties, local.attributes));
    local.handle = reader.value;
  }
  return {};
}

Status EndpointKeys::add(Locals& to, const EntityId& id, LocalKeys local) {
  DDSSEC_RETURN_IF_ERROR(register_local(id, local));
  to[id] = std::move(local);
  return {};
}

void EndpointKeys::remove(Locals& from, const EntityId& id) {
  const auto at = from.find(id);
  if (at == from.end()) return;
  while (!at->second.pairs.empty())
    unregister_pair(from, id, Guid(at->second.pairs.begin()->first), AfterMatch::gone);
  const auto handle = at->second.handle;
  from.erase(at);
  if (handle == 0) return;
  if (is_writer(id))
    static_cast<void>(factory().unregister_datawriter({handle}));
  else
    static_cast<void>(factory().unregister_datareader({handle}));
}

// ---- pairs

Result<std::int64_t> EndpointKeys::register_with_plugin(const EntityId& id, const LocalKeys& local,
                                                        const RemoteCrypto& remote,
                                                        bool is_relay_only) {
  if (is_writer(id)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto matched_remote_datareader,
                            factory().register_matched_remote_datareader(
                                {local.handle}, remote.crypto, *remote.secret, is_relay_only));
    return matched_remote_datareader.value;
  }
  DDSSEC_ASSIGN_OR_RETURN(
      const auto matched_remote_datawriter,
      factory().register_matched_remote_datawriter({local.handle}, remote.crypto, *remote.secret));
  return matched_remote_datawriter.value;
}

Result<std::vector<spi::Token>> EndpointKeys::tokens_for(const EntityId& id, const LocalKeys& local,
                                                         const PairKeys& pair,
                                                         spi::KeyStage stage) {
  auto& exchange = own_.plugins().cryptography.key_exchange();
  if (is_writer(id))
    return exchange.create_local_datawriter_crypto_tokens({local.handle}, {pair.handle}, stage);
  return exchange.create_local_datareader_crypto_tokens({local.handle}, {pair.handle}, stage);
}

Result<PairRegistration> EndpointKeys::register_pair(const EntityId& id, LocalKeys& local,
                                                     const Guid& remote, bool is_relay_only) {
  PairKeys pair{.is_ready = true, .is_relay_only = is_relay_only};
  PairRegistration out{.is_ready = true, .is_new = true};
  if (local.handle != 0) {
    const auto peer = remotes_.find(remote.prefix);
    if (peer == remotes_.end()) return fail(Code::crypto_not_matched);
    DDSSEC_ASSIGN_OR_RETURN(pair.handle,
                            register_with_plugin(id, local, peer->second, is_relay_only));
    auto& newest = newest_[{remote, local.protection}];
    ++newest.pairs;
    endpoint_of_[pair.handle] = {remote, local.protection, id, &newest};
    if (!local.is_volatile) {
      DDSSEC_ASSIGN_OR_RETURN(out.tokens, tokens_for(id, local, pair));
      out.is_ready = pair.is_ready = !waits_for_tokens(id, local.attributes);
    }
  }
  auto& registered = local.pairs[remote] = pair;
  local.list(id, remote, registered);
  out.displaced = local.note_idle(remote, registered);
  return out;
}

std::optional<Guid> EndpointKeys::unregister_pair(Locals& from, const EntityId& id,
                                                  const Guid& remote, AfterMatch after) {
  const auto at = from.find(id);
  if (at == from.end()) return std::nullopt;
  const auto pair = at->second.pairs.find(remote);
  if (pair == at->second.pairs.end()) return std::nullopt;
  const auto handle = pair->second.handle;
  at->second.unlist(id, pair->second);
  const bool stays = after != AfterMatch::gone && handle != 0 && !at->second.is_volatile;
  pair->second.is_suspended = stays && after == AfterMatch::may_return;
  pair->second.is_silent = stays && after == AfterMatch::silent;
  if (pair->second.is_suspended && own_.attributes().is_key_revision_enabled)
    pair->second.are_keys_doubtful = waits_for_tokens(id, at->second.attributes);
  if (stays) return at->second.note_idle(remote, pair->second);
  at->second.idle.remove(remote);
  at->second.pairs.erase(pair);
  forget(handle);
  if (handle == 0) return std::nullopt;
  // The remote endpoint is of the other kind.
  if (is_writer(id))
    static_cast<void>(factory().unregister_datareader({handle}));
  else
    static_cast<void>(factory().unregister_datawriter({handle}));
  return std::nullopt;
}

void EndpointKeys::resume(const EntityId& id, LocalKeys& local, const Guid& remote,
                          PairKeys& pair) const {
  pair.is_suspended = pair.is_silent = false;
  const auto peer = remotes_.find(remote.prefix);
  const bool may_ask = peer != remotes_.end() && peer->second.answers_key_requests;
  if (!may_ask) pair.are_keys_doubtful = false;
  if (pair.are_keys_doubtful) pair.is_ready = false;
  local.list(id, remote, pair);
}

void EndpointKeys::unregister_pairs_of(Locals& from, const GuidPrefix& remote) {
  for (auto& [id, local] : from)
    for (auto at = local.pairs.lower_bound({remote, {}});
         at != local.pairs.end() && at->first.prefix == remote;)
      unregister_pair(from, id, Guid((at++)->first), AfterMatch::gone);
}

void EndpointKeys::note_revision(std::int64_t handle, spi::KeyRevision revision) {
  const auto at = endpoint_of_.find(handle);
  if (at == endpoint_of_.end()) return;
  auto& newest = at->second.newest->revision;
  newest = std::max(newest, revision);
}

void EndpointKeys::forget(std::int64_t handle) {
  const auto at = endpoint_of_.find(handle);
  if (at == endpoint_of_.end()) return;
  const auto& pair = at->second;
  if (--pair.newest->pairs == 0) newest_.erase({pair.guid, pair.protection});
  endpoint_of_.erase(at);
}

const EndpointKeys::Endpoint* EndpointKeys::endpoint_of(std::int64_t handle) const {
  const auto at = endpoint_of_.find(handle);
  return at == endpoint_of_.end() ? nullptr : &at->second;
}

}  // namespace ddssec::rtps
