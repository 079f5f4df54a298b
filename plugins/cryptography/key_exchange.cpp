#include "plugins/cryptography/key_exchange.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "plugins/cryptography/key_revision.hpp"

namespace ddssec::cryptography {
namespace {

// Returns the token for a local key: with the receiver-specific part if there is one, and for
// ddssec peers with the present position.
spi::Token token_for(const SendKey& key, const ReceiverKey* receiver, const ParticipantPair& to) {
  auto material = key.material().clone();
  const ReadGuard guard;  // a sending thread may change to the next session
  if (to.peer_uses_ddssec()) material.position = key.position();
  if (receiver != nullptr) {
    material.receiver_key_id = receiver->id();
    material.receiver_key = receiver->master().clone();
  }
  return crypto_token(material);
}

// Returns the local key for submessages to that endpoint; nullptr if there is none, or no revised
// one.
const SendKey* own_submessage_key(const RemoteEndpointCrypto& to, bool revised) {
  const auto& own = to.local;
  if (to.peer_key) return revised ? to.peer_key->next.get() : to.peer_key->key.read();
  return revised ? own.next_submessage_key.get() : own.submessage_key.read();
}

// The tokens from the host, or those in the ledger if the host presented a ticket.
class HeldTokens {
 public:
  HeldTokens(const CryptographyState& state, std::span<const spi::Token> from_host,
             const TicketUser& user = {})
      : held_(state.host_checks_sources ? std::nullopt : state.ledger.redeem(from_host, user)),
        tokens_(held_ ? std::span<const spi::Token>(held_->tokens) : from_host) {}
  HeldTokens(const HeldTokens&) = delete;
  HeldTokens& operator=(const HeldTokens&) = delete;
  ~HeldTokens() {
    if (held_) wipe_tokens(held_->tokens);
  }

  std::span<const spi::Token> tokens() const { return tokens_; }
  // True if the ticket is from a session with the same peer that has ended: the ledger waits for
  // the tokens of the present session.
  bool are_awaited() const { return held_ && held_->tokens.empty(); }
  // Returns the endpoint that owns the tokens from the ledger; zero if it is not known.
  EntityId owner() const { return held_ ? held_->remote.entity : EntityId{}; }
  // Success if tokens from the ledger are used for the participant that sent them. Error:
  // crypto_not_matched.
  Status check_source(const ParticipantPair& pair) const {
    if (held_ && pair.peer_prefix && held_->remote.prefix != *pair.peer_prefix)
      return fail(Code::crypto_not_matched);
    return {};
  }

 private:
  std::optional<TokenLedger::StoredTokens> held_;
  std::span<const spi::Token> tokens_;
};

Result<std::vector<KeyMaterial>> read_all(std::span<const spi::Token> tokens) {
  std::vector<KeyMaterial> materials;
  for (const auto& token : tokens) {
    DDSSEC_ASSIGN_OR_RETURN(auto material, read_crypto_token(token));
    const bool twice = std::ranges::any_of(
        materials, [&](const auto& one) { return one.sender_key_id == material.sender_key_id; });
    if (twice) return fail(Code::key_material_key_id);
    materials.push_back(std::move(material));
  }
  return materials;
}

bool fits(const KeyMaterial& material, spi::ProtectionKind due) {
  const auto traits = traits_of(material.kind);
  return traits && traits->encrypts == is_encrypted(due);
}

bool are_same(const std::shared_ptr<ReceiveKey>& a, const std::shared_ptr<ReceiveKey>& b) {
  return (a == nullptr) == (b == nullptr) && (a == nullptr || a->material() == b->material());
}

void keep_position(RemoteKeys& next, const RemoteKeys* present) {
  if (present != nullptr && next.submessage && are_same(next.submessage, present->submessage))
    next.submessage->count_from(*present->submessage);
}

// Shares the position of a key for payloads only. Cyclone DDS decrypts a payload once, with the key
// of the first reader, for all readers. Other hosts decrypt it for each reader.
void share_payload_position(const CryptographyState& state, RemoteKeys& next,
                            RemoteEndpointCrypto& remote) {
  const auto* const present = remote.remote_keys.read();
  if (!next.payload || !next.payload->position()) return;
  if (present != nullptr && are_same(next.payload, present->payload))
    return next.payload->count_from(*present->payload);
  if (!state.host_checks_sources) remote.participant.payload_positions.share(*next.payload);
}

// A host passes a submessage that one local endpoint can decrypt to all endpoints that receive from
// the same sender, so these share the position. A host that does not check sources
// (host_checks_sources is false) asks about each submessage only once, so they also share the
// window of repetitions. Otherwise an attacker could break the MAC for one endpoint in a recorded
// submessage, and it would be new to the next endpoint.
void share_state(const CryptographyState& state, RemoteKeys& next,
                 const RemoteEndpointCrypto& remote) {
  const auto* const present = remote.remote_keys.read();
  if (!next.submessage) return;
  if (present != nullptr && are_same(next.submessage, present->submessage))
    return keep_position(next, present);
  const auto* const other = remote.participant.routes.same_sender_key(next.submessage->material());
  if (other == nullptr) return;
  next.submessage->count_with(*other);
  if (!state.host_checks_sources) next.submessage->share_window(*other);
}

// Shares the window for the messages of a participant that several local participants know.
void share_window(RemoteKeys& next, const RemoteParticipantCrypto& remote) {
  for (const auto& [local, pair] : remote.pairs) {
    const auto* const keys = pair->remote_keys.read();
    if (keys == nullptr || !keys->submessage) continue;
    const auto& theirs = keys->submessage->material();
    const auto& own = next.submessage->material();
    if (theirs.sender_key_id == own.sender_key_id && theirs.kind == own.kind)
      return next.submessage->share_window(*keys->submessage);
  }
}

// True if submessages under either key find the same route.
bool route_alike(const RemoteKeys& next, const std::unique_ptr<RemoteKeys>& former) {
  if (!former || !former->submessage) return false;
  const auto& a = next.submessage->material();
  const auto& b = former->submessage->material();
  return a.sender_key_id == b.sender_key_id && a.receiver_key_id == b.receiver_key_id;
}

// Success if no other endpoint has the key (key_owner.hpp).
Status check_owner(const RemoteEndpointCrypto& remote, const RemoteKeys& keys) {
  if (!keys.submessage || keys.owner.is_zero()) return {};
  const auto id = keys.submessage->material().sender_key_id;
  const auto owner = remote.participant.routes.other_owner(id, keys.owner);
  if (owner.is_zero()) return {};
  return fail(Code::key_material_key_id,
              {.document = "crypto tokens",
               .field = "sender_key_id",
               .expected = "a key of one endpoint",
               .found = id.to_string() + ", which is also that of " + owner.to_string()});
}

// Success if the endpoint was announced where the governance demands it. An endpoint that was
// announced in the clear could avoid the check of access control without being noticed here. Error:
// keys_not_permitted.
Status check_announced(const RemoteEndpointCrypto& remote, const ParticipantPair& pair,
                       const EntityId& owner) {
  const auto& local = remote.local;
  if (!local.gate || !local.is_discovery_protected || owner.is_zero() || !pair.peer_prefix)
    return {};
  const bool is_writer = remote.kind() == EntityKind::remote_writer;
  if (remote.participant.discovery.announced.has_secured(owner, is_writer)) return {};
  return fail(Code::keys_not_permitted,
              {.document = "crypto tokens",
               .expected = "an endpoint that the secure discovery has announced",
               .found = owner.to_string(),
               .hint = "the peer must announce it in the secure discovery, as the governance "
                       "demands; one that does not is hostile, or has another governance"});
}

// Success if the cipher may be used with this peer. AES always may.
Status check_cipher(const KindTraits& traits, const ParticipantPair& from) {
  if (traits.cipher != Cipher::chacha20_poly1305) return {};
  if ((from.peer_ciphers & spi::kChaCha20Poly1305Bit) == 0)
    return fail(Code::cipher_not_announced,
                {.expected = spi::names_of(from.peer_ciphers), .found = traits.kind.to_string()});
  if ((from.local.allowed_ciphers & spi::kChaCha20Poly1305Bit) == 0)
    return fail(Code::cipher_not_allowed, {.expected = spi::names_of(from.local.allowed_ciphers),
                                           .found = traits.kind.to_string()});
  return {};
}

}  // namespace

// Accepts only a key that does exactly what the governance demands, with a cipher that the peer
// announced: only then does a vendor-specific number have the same meaning on both sides.
Result<std::unique_ptr<ReceiveKey>> KeyExchange::receive_key(KeyMaterial material,
                                                             spi::ProtectionKind due,
                                                             const ParticipantPair& from) const {
  if (!fits(material, due))
    return fail(Code::key_material_kind_mismatch,
                {.expected = std::string(to_string(due)), .found = material.kind.to_string()});
  if (is_origin_authenticated(due) && !material.has_receiver_key())
    return fail(Code::receiver_specific_key_missing);
  if (!from.local.revises_keys && revision_of(material.kind) != 0)
    return fail(Code::key_revision_not_enabled, {.found = material.kind.to_string()});
  const auto traits = *traits_of(material.kind);
  DDSSEC_RETURN_IF_ERROR(check_cipher(traits, from));
  if (material.position && !from.peer_uses_ddssec()) return fail(Code::key_material_length);
  return std::make_unique<ReceiveKey>(std::move(material), traits, state_.keys);
}

Status KeyExchange::check_replacement(const RemoteKeys& next, const RemoteKeys* present,
                                      const ParticipantPair* from) const {
  if (state_.host_checks_sources || present == nullptr) return {};
  if (are_same(next.submessage, present->submessage) && are_same(next.payload, present->payload))
    return {};
  if (is_later_revision(next, *present)) return {};
  const Error error(Code::keys_already_set, {.document = "crypto tokens"});
  state_.report(error, from != nullptr ? from->peer_prefix : std::nullopt);
  return std::unexpected(error);
}

Result<std::vector<spi::Token>> KeyExchange::create_local_participant_crypto_tokens(
    spi::ParticipantCryptoHandle local, spi::ParticipantCryptoHandle remote, spi::KeyStage stage) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto* const participant, state_.local_participant(local));
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(remote));
  const auto* const pair = remote_participant->pair(local.value);
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  const bool revised = stage == spi::KeyStage::revised;
  const auto* const key = revised ? participant->next_key.get() : participant->key.read();
  std::vector<spi::Token> tokens;
  if (key == nullptr && revised) return tokens;
  // There is always exactly one token, because Fast DDS refuses any other number. Its kind is NONE
  // if nothing is protected.
  tokens.push_back(key != nullptr ? token_for(*key, pair->receiver_key.get(), *pair)
                                  : crypto_token(KeyMaterial{}));
  return tokens;
}

Status KeyExchange::set_remote_participant_crypto_tokens(spi::ParticipantCryptoHandle local,
                                                         spi::ParticipantCryptoHandle remote,
                                                         std::span<const spi::Token> tokens) {
  const HeldTokens held(state_, tokens);
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto* const participant, state_.local_participant(local));
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(remote));
  auto* const pair = remote_participant->pair(local.value);
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  DDSSEC_RETURN_IF_ERROR(held.check_source(*pair));
  auto status = accept(*participant, remote, *pair, held.tokens());
  if (!status && !state_.host_checks_sources && status.error().code() != Code::keys_already_set)
    state_.report(status.error(), pair->peer_prefix);
  return status;
}

Status KeyExchange::accept(const LocalParticipantCrypto& participant,
                           spi::ParticipantCryptoHandle remote, ParticipantPair& pair,
                           std::span<const spi::Token> tokens) {
  if (tokens.size() != 1) return fail(Code::crypto_token_count);
  DDSSEC_ASSIGN_OR_RETURN(auto material, read_crypto_token(tokens.front()));
  // Fast DDS sends a GMAC key even if nothing is protected.
  if (!is_protected(participant.rtps)) return {};
  auto keys = std::make_unique<RemoteKeys>();
  DDSSEC_ASSIGN_OR_RETURN(keys->submessage,
                          receive_key(std::move(material), participant.rtps, pair));
  DDSSEC_RETURN_IF_ERROR(check_replacement(*keys, pair.remote_keys.read(), &pair));
  if (!state_.host_checks_sources) {
    DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(remote));
    share_window(*keys, *remote_participant);
  }
  keep_position(*keys, pair.remote_keys.read());
  DDSSEC_RETURN_IF_ERROR(
      inherit(*keys, pair.remote_keys.read(), state_.services.clock.monotonic()));
  state_.note_former(remote.value, *keys);
  pair.remote_keys.replace(std::move(keys), state_.retired_objects);
  return {};
}

template <class Local, class Remote>
Result<RemoteEndpointCrypto*> KeyExchange::matched(Local local, Remote remote) const {
  DDSSEC_RETURN_IF_ERROR(state_.local_endpoint(local, local_kind(local)));
  DDSSEC_ASSIGN_OR_RETURN(auto* const endpoint,
                          state_.remote_endpoint(remote, remote_kind(remote)));
  if (endpoint->local.handle() != local.value) return fail(Code::crypto_not_matched);
  return endpoint;
}

template <class Local, class Remote>
Result<std::vector<spi::Token>> KeyExchange::create(Local local, Remote remote,
                                                    spi::KeyStage stage) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto found_endpoint, matched(local, remote));
  const auto& endpoint = *found_endpoint;
  std::vector<spi::Token> tokens;
  // The submessage key comes before the payload key: receivers use the first one for routing.
  const auto& own = endpoint.local;
  const auto* const pair = endpoint.participant.pair(own.participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  const bool revised = stage == spi::KeyStage::revised;
  if (const auto* key = own_submessage_key(endpoint, revised))
    tokens.push_back(token_for(*key, endpoint.receiver_key.get(), *pair));
  if (const auto* key = revised ? own.next_payload_key.get() : own.payload_key.read())
    tokens.push_back(token_for(*key, nullptr, *pair));
  if (const auto& material = own.unused_reader_key; material && !revised)
    tokens.push_back(crypto_token(*material));
  return tokens;
}

// Assigns one or two materials to the levels. A single one serves all levels that need one (Fast
// DDS shares its key if both levels encrypt or both sign). Of two, the first is for submessages.
Result<std::unique_ptr<RemoteKeys>> KeyExchange::endpoint_keys(
    const RemoteEndpointCrypto& remote, std::vector<KeyMaterial> materials) const {
  const auto& local = remote.local;
  const auto* const pair = remote.participant.pair(local.participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  auto keys = std::make_unique<RemoteKeys>();
  if (remote.kind() == EntityKind::remote_writer && is_protected(local.payload)) {
    auto payload = materials.back().clone();
    payload.receiver_key_id = {};  // payloads have no receiver-specific MACs
    payload.receiver_key = {};
    // A payload inside a protected submessage needs no replay check of its own.
    if (is_protected(local.submessage)) payload.position.reset();
    DDSSEC_ASSIGN_OR_RETURN(keys->payload, receive_key(std::move(payload), local.payload, *pair));
  }
  if (is_protected(local.submessage)) {
    DDSSEC_ASSIGN_OR_RETURN(keys->submessage,
                            receive_key(std::move(materials.front()), local.submessage, *pair));
  }
  return keys;
}

// The content of a token is used only after every check. The endpoint keeps its keys until
// `install`. Only the payload positions that its participant remembers for a sender key may grow
// here.
Result<std::unique_ptr<RemoteKeys>> KeyExchange::checked_keys(RemoteEndpointCrypto& endpoint,
                                                              const ParticipantPair& pair,
                                                              std::span<const spi::Token> tokens,
                                                              EntityId owner) const {
  DDSSEC_ASSIGN_OR_RETURN(auto materials, read_all(tokens));
  DDSSEC_ASSIGN_OR_RETURN(auto keys, endpoint_keys(endpoint, std::move(materials)));
  const auto* const present = endpoint.remote_keys.read();
  keys->owner = present != nullptr && owner.is_zero() ? present->owner : owner;
  DDSSEC_RETURN_IF_ERROR(check_owner(endpoint, *keys));
  DDSSEC_RETURN_IF_ERROR(check_replacement(*keys, present, &pair));
  share_state(state_, *keys, endpoint);
  share_payload_position(state_, *keys, endpoint);
  DDSSEC_RETURN_IF_ERROR(inherit(*keys, present, state_.services.clock.monotonic()));
  return keys;
}

// The route leads to the new keys only once they are there. If there is not enough memory for it,
// the former keys are put back.
void KeyExchange::install(RemoteEndpointCrypto& endpoint, std::unique_ptr<RemoteKeys> keys) {
  state_.note_former(endpoint.handle(), *keys);
  auto former = endpoint.remote_keys.exchange(std::move(keys));
  Rollback undo([&] { endpoint.remote_keys.replace(std::move(former), state_.retired_objects); });
  if (is_protected(endpoint.local.submessage)) {
    const bool has_route = endpoint.route != 0 && route_alike(*endpoint.remote_keys.read(), former);
    auto& routes = endpoint.participant.routes;
    if (!has_route && !routes.is_outdated(endpoint))
      state_.publish_route(endpoint);
    else if (!has_route && endpoint.route.exchange(0) != 0)
      routes.note_gone();  // it was that of another key
    routes.end_outdated(endpoint);
  }
  undo.release();
  state_.retired_objects.retire(std::move(former));
}

template <class Local, class Remote>
Status KeyExchange::set(Local local, Remote remote, std::span<const spi::Token> from_host) {
  const std::lock_guard lock(state_.mutex);
  const auto found = matched(local, remote);
  const auto* const pair =
      found ? (*found)->participant.pair((*found)->local.participant.handle()) : nullptr;
  const HeldTokens held(state_, from_host,
                        {pair == nullptr ? 0 : pair->number, local.value, remote.value});
  const auto tokens = held.tokens();
  DDSSEC_RETURN_IF_ERROR(found);
  auto& endpoint = **found;
  if (!endpoint.local.has_tokens()) return fail(Code::crypto_tokens_not_expected);
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  DDSSEC_RETURN_IF_ERROR(held.check_source(*pair));
  if (const auto status = check_announced(endpoint, *pair, held.owner()); !status) {
    const auto& announced = endpoint.participant.discovery.announced;
    const bool is_writer = endpoint.kind() == EntityKind::remote_writer;
    // An application may delete an endpoint before its keys have come. That is no attack.
    if (!announced.has_ended(held.owner(), is_writer))
      state_.report(status.error(), pair->peer_prefix);
    return status;
  }
  // A place is taken now and not at the announcement. A host that trusts unprotected discovery also
  // registers readers that an attacker invented in the peer's name. It sends nothing to a reader
  // whose tokens have not come.
  const bool had_place = endpoint.place_subject.has_value();
  DDSSEC_RETURN_IF_ERROR(state_.claim_place(endpoint, *pair));
  Rollback release([&] {
    if (!had_place) state_.release_place(endpoint);
  });
  if (held.are_awaited()) {  // the host continues as if the keys had arrived
    release.release();
    return {};
  }
  if (tokens.empty() || tokens.size() > kMaxTokensPerEndpoint)
    return fail(Code::crypto_token_count);
  DDSSEC_ASSIGN_OR_RETURN(auto keys, checked_keys(endpoint, *pair, tokens, held.owner()));
  install(endpoint, std::move(keys));
  release.release();
  return {};
}

Result<std::vector<spi::Token>> KeyExchange::create_local_datawriter_crypto_tokens(
    spi::DatawriterCryptoHandle local, spi::DatareaderCryptoHandle remote, spi::KeyStage stage) {
  return create(local, remote, stage);
}

Status KeyExchange::set_remote_datawriter_crypto_tokens(spi::DatareaderCryptoHandle local,
                                                        spi::DatawriterCryptoHandle remote,
                                                        std::span<const spi::Token> tokens) {
  return set(local, remote, tokens);
}

Result<std::vector<spi::Token>> KeyExchange::create_local_datareader_crypto_tokens(
    spi::DatareaderCryptoHandle local, spi::DatawriterCryptoHandle remote, spi::KeyStage stage) {
  return create(local, remote, stage);
}

Status KeyExchange::set_remote_datareader_crypto_tokens(spi::DatawriterCryptoHandle local,
                                                        spi::DatareaderCryptoHandle remote,
                                                        std::span<const spi::Token> tokens) {
  return set(local, remote, tokens);
}

// The position is not part of the keys: it is another one each time that the same keys are sent.
Sha256Digest KeyExchange::digest_of(std::span<const spi::Token> tokens) const {
  Sha256Digest out{};
  for (const auto& token : tokens) {
    auto material = read_crypto_token(token);
    if (!material) continue;
    material->position.reset();
    auto octets = serialize_key_material(*material);
    out = sha256({out, octets});
    wipe(octets);
  }
  return out;
}

// All keys of an entity are revised together.
spi::KeyRevision KeyExchange::key_revision_of(std::span<const spi::Token> tokens) const {
  if (tokens.empty()) return 0;
  const auto material = read_crypto_token(tokens.front());
  return material ? revision_of(material->kind) : 0;
}

}  // namespace ddssec::cryptography
