#include "plugins/cryptography/key_factory.hpp"

#include <algorithm>
#include <cstring>

#include "base/rollback.hpp"
#include "plugins/cryptography/cipher_choice.hpp"
#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::string_view kVolatileWriterName = "BuiltinParticipantVolatileMessageSecureWriter";
constexpr std::string_view kVolatileReaderName = "BuiltinParticipantVolatileMessageSecureReader";

// True if the properties are those of a volatile secure endpoint (DDS-Security 1.2,
// clause 9.8.9.1).
bool is_volatile(EntityKind kind, const spi::PropertyList& properties) {
  const auto* const name = spi::find_property(properties, spi::property::kBuiltinEndpointName);
  return name != nullptr &&
         *name == (kind == EntityKind::local_writer ? kVolatileWriterName : kVolatileReaderName);
}

// True if both have the same material, which means the same shared secret.
bool same_key_exchange(const ParticipantPair& a, const ParticipantPair& b) {
  return a.key_exchange_send->material().sender_key == b.key_exchange_send->material().sender_key;
}

// The host matches a new local endpoint with all known ones in the thread that made it, and at
// once. A listener makes endpoints in the thread that later also matches what peers announce.
DiscoveryWork::Cause cause_at(const LocalEndpointCrypto& local, MonotonicTime now) {
  constexpr MonotonicTime kNew = std::chrono::seconds(10);
  const bool is_new =
      pthread_equal(local.creating_thread, pthread_self()) != 0 && now - local.created_at < kNew;
  return is_new ? DiscoveryWork::Cause::host : DiscoveryWork::Cause::peer;
}

}  // namespace

// A host that checks sources limits them itself. Endpoints whose announcements are not protected
// are not counted: an attacker can invent them in the peer's name.
bool KeyFactory::is_counted(const LocalEndpointCrypto& local) const {
  return !state_.host_checks_sources && !local.is_builtin && local.is_discovery_protected;
}

template <class T>
Result<T> KeyFactory::random() {
  std::array<std::uint8_t, sizeof(T)> octets;
  DDSSEC_RETURN_IF_ERROR(state_.services.random.fill(octets));
  T value;
  std::memcpy(&value, octets.data(), sizeof value);
  return value;
}

template <class Key>
Result<Key> KeyFactory::random_key(std::size_t size) {
  return Key::fill(size, [&](MutableBytes out) { return state_.services.random.fill(out); });
}

// The id is unique among all local participants. It is never 0, which is the id of the key
// exchange's key.
KeyId KeyFactory::fresh_key_id() {
  if (next_key_id_ == 0) ++next_key_id_;
  const auto number = next_key_id_++;
  KeyId id;
  for (std::size_t i = 0; i < 4; ++i)
    id.octets[i] = static_cast<std::uint8_t>(number >> (24 - 8 * i));
  return id;
}

Result<KeyMaterial> KeyFactory::fresh_material(bool encrypts, Cipher cipher) {
  return fresh_material(kind_for(cipher, encrypts), fresh_key_id());
}

Result<KeyMaterial> KeyFactory::fresh_material(TransformKind kind, KeyId id) {
  const auto size = traits_of(kind)->key_size();
  KeyMaterial material{.kind = kind};
  DDSSEC_ASSIGN_OR_RETURN(material.salt, random_key<MasterSalt>(size));
  material.sender_key_id = id;
  DDSSEC_ASSIGN_OR_RETURN(material.sender_key, random_key<MasterKey>(size));
  return material;
}

Result<std::unique_ptr<SendKey>> KeyFactory::send_key(KeyMaterial material) {
  DDSSEC_ASSIGN_OR_RETURN(const auto start, SendStart::draw(state_.services.random));
  return SendKey::create(std::move(material), start, state_.keys);
}

Result<std::unique_ptr<ReceiverKey>> KeyFactory::receiver_key(Cipher cipher) {
  DDSSEC_ASSIGN_OR_RETURN(auto key, random_key<MasterReceiverKey>(key_size_of(cipher)));
  return std::make_unique<ReceiverKey>(fresh_key_id(), std::move(key), state_.keys);
}

Status KeyFactory::check_cipher(Cipher cipher, spi::CipherMask allowed) const {
  const auto here = allowed & supported_ciphers();
  if ((here & bit_of(cipher)) != 0) return {};
  return fail(Code::cipher_not_allowed, {.field = "symmetric cipher",
                                         .expected = spi::names_of(here),
                                         .found = spi::names_of(bit_of(cipher))});
}

spi::CipherMask KeyFactory::supported_ciphers() const { return ciphers_of(state_.keys.aead); }

Result<spi::SymmetricCipherInfo> KeyFactory::cipher_info(spi::ParticipantCryptoHandle local) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto local_participant, state_.local_participant(local));
  const auto& participant = *local_participant;
  return spi::SymmetricCipherInfo{.supported = supported_ciphers() & participant.allowed_ciphers,
                                  .builtin_required = bit_of(participant.cipher),
                                  .key_exchange_required = spi::kAes256Bit,
                                  .user_default_required = bit_of(participant.endpoint_cipher)};
}

Result<spi::CipherMask> KeyFactory::required_ciphers(spi::DatawriterCryptoHandle local) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto local_endpoint,
                          state_.local_endpoint(local, EntityKind::local_writer));
  return bit_of(local_endpoint->cipher);
}

Result<spi::CipherMask> KeyFactory::required_ciphers(spi::DatareaderCryptoHandle local) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto local_endpoint,
                          state_.local_endpoint(local, EntityKind::local_reader));
  return bit_of(local_endpoint->cipher);
}

Result<spi::ParticipantCryptoHandle> KeyFactory::register_local_participant(
    spi::IdentityHandle, spi::PermissionsHandle, const spi::PropertyList& properties,
    const spi::ParticipantSecurityAttributes& attributes) {
  const std::lock_guard lock(state_.mutex);
  auto participant = std::make_unique<LocalParticipantCrypto>();
  DDSSEC_ASSIGN_OR_RETURN(const auto ciphers, participant_ciphers(properties));
  participant->cipher = ciphers.message;
  participant->endpoint_cipher = ciphers.endpoint;
  participant->allowed_ciphers = attributes.allowed_ciphers;
  for (const auto cipher : {ciphers.message, ciphers.endpoint})
    DDSSEC_RETURN_IF_ERROR(check_cipher(cipher, attributes.allowed_ciphers));
  participant->rtps = attributes.rtps;
  participant->protects_discovery = attributes.is_discovery_protected();
  participant->closed_discovery = {.secure_topics = attributes.is_discovery_protected(),
                                   .clear_topics = attributes.is_all_discovery_protected};
  participant->revises_keys = attributes.is_key_revision_enabled;
  DDSSEC_ASSIGN_OR_RETURN(participant->trusts_type_information,
                          spi::flag_property(properties, spi::property::kTrustTypeInformation));
  DDSSEC_RETURN_IF_ERROR(limit_keys(*participant, properties));
  if (is_protected(attributes.rtps)) {
    DDSSEC_ASSIGN_OR_RETURN(auto material,
                            fresh_material(is_encrypted(attributes.rtps), participant->cipher));
    DDSSEC_ASSIGN_OR_RETURN(auto fresh_key, send_key(std::move(material)));
    participant->key.replace(std::move(fresh_key), state_.retired_objects);
  }
  const auto& added = *participant;
  DDSSEC_RETURN_IF_ERROR(state_.registry.add(std::move(participant)));
  return spi::ParticipantCryptoHandle{added.handle()};
}

Status KeyFactory::begin_life(LocalParticipantCrypto& participant) {
  if (!participant.life.is_limited()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto random_number, random<std::uint64_t>());
  participant.life.begin(state_.services.clock.monotonic(), random_number);
  return {};
}

Result<std::unique_ptr<ParticipantPair>> KeyFactory::make_pair(
    const LocalParticipantCrypto& local, const spi::SharedSecret& shared_secret) {
  if (shared_secret.secret.empty()) return fail(Code::length_out_of_range);
  if (local.key.read() != nullptr)
    DDSSEC_RETURN_IF_ERROR(check_peer(local.cipher, shared_secret.peer_ciphers));
  auto pair = std::make_unique<ParticipantPair>(local);
  pair->number = ++state_.pairs_made;
  pair->peer_ciphers = shared_secret.peer_ciphers;
  pair->peer_prefix = shared_secret.peer_prefix;
  pair->own_prefix = shared_secret.own_prefix;
  auto material = derive_key_exchange_material(shared_secret);
  pair->key_exchange_receive =
      std::make_unique<ReceiveKey>(material.clone(), *traits_of(material.kind), state_.keys);
  // Both directions share the key. A random session id and suffix keep their IVs apart.
  DDSSEC_ASSIGN_OR_RETURN(pair->key_exchange_send, send_key(std::move(material)));
  if (is_origin_authenticated(local.rtps)) {
    DDSSEC_ASSIGN_OR_RETURN(pair->receiver_key, receiver_key(local.cipher));
  }
  return pair;
}

Result<RemoteParticipantCrypto*> KeyFactory::remote_with_identity(spi::IdentityHandle identity) {
  if (!identity) return fail(Code::crypto_handle_nil);
  if (const auto known = by_identity_.find(identity.value); known != by_identity_.end())
    return known->second;
  auto remote = std::make_unique<RemoteParticipantCrypto>(state_.registry);
  remote->identity = identity.value;
  auto* const added = remote.get();
  const auto known = by_identity_.emplace(identity.value, added).first;
  Rollback forget([&] { by_identity_.erase(known); });
  DDSSEC_RETURN_IF_ERROR(state_.registry.add(std::move(remote)));
  forget.release();
  return added;
}

void KeyFactory::publish_pairs(RemoteParticipantCrypto& remote, std::int64_t without) {
  auto table = std::make_unique<PairTable>();
  for (const auto& [local, pair] : remote.pairs)
    if (local != without) table->rows.push_back({local, pair.get()});
  remote.pair_table.replace(std::move(table), state_.retired_objects);
}

Status KeyFactory::claim_place(LocalParticipantCrypto& local, spi::IdentityHandle remote,
                               ParticipantPair& fresh) {
  if (!fresh.receiver_key) return {};
  const auto subject = subject_of(remote.value, fresh);
  if (auto status = local.receivers.claim(subject); !status) {
    state_.report(status.error(), fresh.peer_prefix);
    return status;
  }
  fresh.place_subject = subject;
  return {};
}

ParticipantPair* KeyFactory::known_pair(std::int64_t local, spi::IdentityHandle remote) const {
  const auto known = by_identity_.find(remote.value);
  if (known == by_identity_.end()) return nullptr;
  const auto pair = known->second->pairs.find(local);
  return pair == known->second->pairs.end() ? nullptr : pair->second.get();
}

Result<spi::ParticipantCryptoHandle> KeyFactory::register_matched_remote_participant(
    spi::ParticipantCryptoHandle local, spi::IdentityHandle remote_identity,
    spi::PermissionsHandle remote_permissions, const spi::SharedSecret& shared_secret) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(auto* const participant, state_.local_participant(local));
  DDSSEC_ASSIGN_OR_RETURN(auto fresh, make_pair(*participant, shared_secret));
  fresh->permissions = remote_permissions;
  if (auto* const former = known_pair(local.value, remote_identity)) {
    if (same_key_exchange(*former, *fresh)) {
      former->permissions = remote_permissions;
      return spi::ParticipantCryptoHandle{by_identity_.at(remote_identity.value)->handle()};
    }
    participant->receivers.release(former->place_subject);
  }
  DDSSEC_RETURN_IF_ERROR(claim_place(*participant, remote_identity, *fresh));
  Rollback release([&] { participant->receivers.release(fresh->place_subject); });
  DDSSEC_ASSIGN_OR_RETURN(auto* const remote, remote_with_identity(remote_identity));
  const auto subject = subject_of(remote_identity.value, *fresh);
  remote->discovery.announced.set_account(state_.announcements.of(subject));
  remote->discovery.work.set_account(state_.work.of(subject, state_.services.clock.monotonic()));
  auto& pair = remote->pairs[local.value];
  participant->matched.insert(remote->handle());
  if (pair && !state_.host_checks_sources)
    state_.ledger.end(pair->number, state_.services.clock.monotonic());
  pair.swap(fresh);
  Rollback undo([&] { pair.swap(fresh); });
  publish_pairs(*remote);
  undo.release();
  release.release();
  state_.retired_objects.retire(std::move(fresh));
  return spi::ParticipantCryptoHandle{remote->handle()};
}

Status KeyFactory::make_endpoint_keys(LocalEndpointCrypto& endpoint) {
  if (endpoint.is_volatile) return {};
  const auto cipher = endpoint.cipher;
  const bool protects_submessages = is_protected(endpoint.submessage);
  const auto fresh = [&](spi::ProtectionKind kind) -> Result<std::unique_ptr<SendKey>> {
    DDSSEC_ASSIGN_OR_RETURN(auto material, fresh_material(is_encrypted(kind), cipher));
    return send_key(std::move(material));
  };
  if (protects_submessages && !endpoint.has_peer_keys()) {
    DDSSEC_ASSIGN_OR_RETURN(auto send_key, fresh(endpoint.submessage));
    endpoint.submessage_key.replace(std::move(send_key), state_.retired_objects);
  }
  if (!is_protected(endpoint.payload)) return {};
  if (endpoint.kind() == EntityKind::local_writer) {
    DDSSEC_ASSIGN_OR_RETURN(auto send_key, fresh(endpoint.payload));
    endpoint.payload_key.replace(std::move(send_key), state_.retired_objects);
  } else if (!protects_submessages)
  // Fast DDS 2.9 matches its writer only after a token of the reader, even if it needs none.
  {
    DDSSEC_ASSIGN_OR_RETURN(endpoint.unused_reader_key, fresh_material(false, Cipher::aes256_gcm));
  }
  return {};
}

Result<std::int64_t> KeyFactory::register_local_endpoint(
    EntityKind kind, spi::ParticipantCryptoHandle participant, const spi::PropertyList& properties,
    const spi::EndpointSecurityAttributes& attributes) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(auto* const parent, state_.local_participant(participant));
  auto endpoint = std::make_unique<LocalEndpointCrypto>(kind, *parent);
  endpoint->created_at = state_.services.clock.monotonic();
  endpoint->is_volatile = is_volatile(kind, properties);
  endpoint->is_builtin = attributes.is_builtin;
  endpoint->submessage =
      endpoint->is_volatile ? spi::ProtectionKind::encrypt : attributes.submessage;
  if (!endpoint->is_volatile) endpoint->payload = attributes.payload;
  endpoint->gate = attributes.gate;
  endpoint->is_discovery_protected =
      attributes.topic.is_discovery_protected && parent->protects_discovery;
  const auto otherwise = attributes.is_builtin ? parent->cipher : parent->endpoint_cipher;
  DDSSEC_ASSIGN_OR_RETURN(const auto cipher, cipher_asked(properties));
  endpoint->cipher = cipher.value_or(otherwise);
  DDSSEC_RETURN_IF_ERROR(check_cipher(endpoint->cipher, parent->allowed_ciphers));
  DDSSEC_RETURN_IF_ERROR(make_endpoint_keys(*endpoint));
  const auto& added = *endpoint;
  DDSSEC_RETURN_IF_ERROR(state_.registry.add(std::move(endpoint)));
  Rollback forget([&] { drop(added); });
  parent->endpoints.insert(added.handle());
  forget.release();
  return added.handle();
}

Result<spi::DatawriterCryptoHandle> KeyFactory::register_local_datawriter(
    spi::ParticipantCryptoHandle participant, const spi::PropertyList& properties,
    const spi::EndpointSecurityAttributes& attributes) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto local_endpoint,
      register_local_endpoint(EntityKind::local_writer, participant, properties, attributes));
  return spi::DatawriterCryptoHandle{local_endpoint};
}

Result<spi::DatareaderCryptoHandle> KeyFactory::register_local_datareader(
    spi::ParticipantCryptoHandle participant, const spi::PropertyList& properties,
    const spi::EndpointSecurityAttributes& attributes) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto local_endpoint,
      register_local_endpoint(EntityKind::local_reader, participant, properties, attributes));
  return spi::DatareaderCryptoHandle{local_endpoint};
}

Result<KeyFactory::Match> KeyFactory::find_match(std::int64_t local, EntityKind kind,
                                                 spi::ParticipantCryptoHandle remote) {
  const auto of_ours =
      kind == EntityKind::remote_writer ? EntityKind::local_reader : EntityKind::local_writer;
  DDSSEC_ASSIGN_OR_RETURN(auto* const endpoint,
                          state_.registry.find<LocalEndpointCrypto>(local, of_ours));
  DDSSEC_ASSIGN_OR_RETURN(auto* const parent, state_.remote_participant(remote));
  const auto* const pair = parent->pair(endpoint->participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  return Match{*endpoint, *parent, *pair};
}

// Asks the gate without holding the lock, so that a slow check never delays other peers' messages.
// Afterwards everything is looked up again. If the peer's permissions changed meanwhile, the gate
// is asked once more.
Result<std::int64_t> KeyFactory::match(std::int64_t local, EntityKind kind,
                                       spi::ParticipantCryptoHandle remote) {
  std::optional<spi::PermissionsHandle> admitted;
  std::unique_lock lock(state_.mutex);
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto found, find_match(local, kind, remote));
    const auto gate = found.local.gate;
    if (!gate || admitted == found.pair.permissions) return add_match(found, kind);
    const auto& announced = found.parent.discovery.announced;
    const bool writes = kind == EntityKind::remote_writer;
    const spi::MatchGate::Peer peer{
        .permissions = found.pair.permissions,
        .prefix = found.pair.peer_prefix,
        .writes = writes,
        .hides_endpoints = writes ? announced.hides_writers() : announced.hides_readers()};
    lock.unlock();
    DDSSEC_RETURN_IF_ERROR(gate->check(peer));
    admitted = peer.permissions;
    lock.lock();
  }
}

Status KeyFactory::claim_peer_key(RemoteEndpointCrypto& writer) {
  auto& local = writer.local;
  auto& key = local.peer_keys[writer.participant.handle()];
  if (!key) {
    Rollback forget([&] { local.peer_keys.erase(writer.participant.handle()); });
    auto fresh = std::make_shared<PeerKey>();
    DDSSEC_ASSIGN_OR_RETURN(auto material,
                            fresh_material(is_encrypted(local.submessage), local.cipher));
    DDSSEC_ASSIGN_OR_RETURN(auto fresh_key, send_key(std::move(material)));
    fresh->key.replace(std::move(fresh_key), state_.retired_objects);
    key = std::move(fresh);
    forget.release();
  }
  ++key->writers;
  writer.peer_key = key;
  return {};
}

void KeyFactory::release_peer_key(const RemoteEndpointCrypto& writer) noexcept {
  if (writer.peer_key && --writer.peer_key->writers == 0)
    writer.local.peer_keys.erase(writer.participant.handle());
}

Status KeyFactory::claim_share(RemoteEndpointCrypto& remote, const ParticipantPair& pair) {
  auto& local = remote.local;
  if (!is_counted(local)) return {};
  auto& work = remote.participant.discovery.work;
  const auto now = state_.services.clock.monotonic();
  work.note_attempt(cause_at(local, now), now);
  const auto subject = subject_of(remote.participant.identity, pair);
  if (auto status = local.matches.claim(subject); !status) {
    state_.report(status.error(), pair.peer_prefix);
    return status;
  }
  remote.match_subject = subject;
  if (remote.kind() == EntityKind::remote_reader) {
    work.note_match(local.handle(), local.matched.size(), cause_at(local, now), now);
    remote.is_counted_by_discovery_work = true;
  }
  return {};
}

// The shared secret belongs to the two participants and came with
// register_matched_remote_participant. The volatile endpoints of a pair must share one sender's
// counter instead of starting two.
Result<std::int64_t> KeyFactory::add_match(const Match& match, EntityKind kind) {
  auto& [local, parent, pair] = match;
  if (local.sends_protected()) DDSSEC_RETURN_IF_ERROR(check_peer(local.cipher, pair.peer_ciphers));
  auto remote = std::make_unique<RemoteEndpointCrypto>(kind, local, parent);
  if (!local.is_volatile && is_origin_authenticated(local.submessage)) {
    DDSSEC_ASSIGN_OR_RETURN(remote->receiver_key, receiver_key(local.cipher));
  }
  auto& added = *remote;
  DDSSEC_RETURN_IF_ERROR(state_.registry.add(std::move(remote)));
  Rollback forget([&] { drop_remote(added); });
  if (local.has_peer_keys()) DDSSEC_RETURN_IF_ERROR(claim_peer_key(added));
  if (state_.host_checks_sources) DDSSEC_RETURN_IF_ERROR(state_.claim_place(added, pair));
  DDSSEC_RETURN_IF_ERROR(claim_share(added, pair));
  local.matched.insert(added.handle());
  parent.endpoints.insert(added.handle());
  if (local.is_volatile) state_.publish_route(added);
  forget.release();
  return added.handle();
}

Result<spi::DatareaderCryptoHandle> KeyFactory::register_matched_remote_datareader(
    spi::DatawriterCryptoHandle local_datawriter, spi::ParticipantCryptoHandle remote_participant,
    const spi::SharedSecret&, bool) {
  DDSSEC_ASSIGN_OR_RETURN(const auto matched, match(local_datawriter.value,
                                                    EntityKind::remote_reader, remote_participant));
  return spi::DatareaderCryptoHandle{matched};
}

Result<spi::DatawriterCryptoHandle> KeyFactory::register_matched_remote_datawriter(
    spi::DatareaderCryptoHandle local_datareader, spi::ParticipantCryptoHandle remote_participant,
    const spi::SharedSecret&) {
  DDSSEC_ASSIGN_OR_RETURN(const auto matched, match(local_datareader.value,
                                                    EntityKind::remote_writer, remote_participant));
  return spi::DatawriterCryptoHandle{matched};
}

}  // namespace ddssec::cryptography
