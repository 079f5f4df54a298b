#include "plugins/cryptography/key_revision.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "plugins/cryptography/key_factory.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cryptography {

namespace property = spi::property;

namespace {

// Returns a key that represents all keys of an entity, because they are revised together.
const ReceiveKey* any_of(const LevelKeys& keys) {
  return keys.submessage ? keys.submessage.get() : keys.payload.get();
}

bool revises(const KeyMaterial& next, const KeyMaterial& present) {
  return next.sender_key_id == present.sender_key_id &&
         next.kind.octets[3] == present.kind.octets[3];
}

void keep_living(RemoteKeys& out, const RemoteKeys& of, std::chrono::nanoseconds now) {
  for (const auto& former : of.former)
    if (now < former.until && out.former.size() < kMaxFormerRevisions) out.former.push_back(former);
}

}  // namespace

KeyRevision revision_of(TransformKind kind) {
  return static_cast<KeyRevision>(kind.octets[0] << 16 | kind.octets[1] << 8 | kind.octets[2]);
}

TransformKind with_revision(TransformKind kind, KeyRevision revision) {
  for (std::size_t i = 0; i < 3; ++i)
    kind.octets[i] = static_cast<std::uint8_t>(revision >> (16 - 8 * i));
  return kind;
}

bool is_later(KeyRevision revision, KeyRevision than) {
  if (revision == 0 || than == 0) return revision != 0;
  const auto ahead = (revision + kLastKeyRevision - than) % kLastKeyRevision;
  return ahead != 0 && ahead <= kLastKeyRevision / 2;
}

Status inherit(RemoteKeys& next, const RemoteKeys* present, std::chrono::nanoseconds now) {
  const auto* const to = any_of(next);
  const auto* const from = present != nullptr ? any_of(*present) : nullptr;
  if (to == nullptr || from == nullptr || !revises(to->material(), from->material())) return {};
  const auto fresh = revision_of(to->material().kind);
  const auto old = revision_of(from->material().kind);
  if (fresh != old) {
    if (!is_later(fresh, old))
      return fail(Code::key_revision_stale, {.field = "transformation_key_revision",
                                             .expected = "later than " + std::to_string(old),
                                             .found = std::to_string(fresh)});
    next.former.push_back({*present, now + kFormerKeyLife});
  }
  keep_living(next, *present, now);
  return {};
}

bool is_later_revision(const RemoteKeys& next, const RemoteKeys& present) {
  const auto* const to = any_of(next);
  const auto* const from = any_of(present);
  return to != nullptr && from != nullptr && revises(to->material(), from->material()) &&
         is_later(revision_of(to->material().kind), revision_of(from->material().kind));
}

std::unique_ptr<RemoteKeys> without_ended(const RemoteKeys& keys, std::chrono::nanoseconds now) {
  auto out = std::make_unique<RemoteKeys>();
  static_cast<LevelKeys&>(*out) = keys;
  out->owner = keys.owner;
  keep_living(*out, keys, now);
  return out;
}

ReceiveKey* former_key(const RemoteKeys& keys, KeyLevel level, TransformKind kind,
                       std::chrono::nanoseconds now) {
  for (const auto& former : keys.former) {
    auto* const key = (former.*level).get();
    if (key != nullptr && key->material().kind == kind && now < former.until) return key;
  }
  return nullptr;
}

// ---- revisions of local keys

Result<std::unique_ptr<SendKey>> KeyFactory::revised(const PublishedPointer<SendKey>& key) {
  const auto* const present = key.read();
  if (present == nullptr) return nullptr;
  const auto& of = present->material();
  const auto kind = with_revision(of.kind, next_revision(revision_of(of.kind)));
  DDSSEC_ASSIGN_OR_RETURN(auto material, fresh_material(kind, of.sender_key_id));
  return send_key(std::move(material));
}

template <class F>
void KeyFactory::each_endpoint(const LocalParticipantCrypto& participant, F&& f) const {
  for (const auto handle : participant.endpoints)
    for (const auto kind : {EntityKind::local_writer, EntityKind::local_reader})
      if (const auto found = state_.registry.find<LocalEndpointCrypto>(handle, kind)) f(**found);
}

// All keys are made before any takes effect, so that a failure leaves everything as it was.
Result<KeyRevision> KeyFactory::revise_local_entity_keys(spi::ParticipantCryptoHandle local) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto local_participant, state_.local_participant(local));
  auto& participant = *local_participant;
  if (!participant.revises_keys) return KeyRevision{0};
  if (participant.is_revising) return fail(Code::key_revision_out_of_turn);
  const auto undo = [&] {
    participant.next_key.reset();
    each_endpoint(participant, cancel_revision);
  };
  Rollback rollback(undo);
  Status status;
  DDSSEC_ASSIGN_OR_RETURN(participant.next_key, revised(participant.key));
  each_endpoint(participant, [&](LocalEndpointCrypto& endpoint) {
    if (status) status = revise(endpoint);
  });
  DDSSEC_RETURN_IF_ERROR(std::move(status));
  DDSSEC_RETURN_IF_ERROR(begin_life(participant));
  rollback.release();
  participant.is_revising = true;
  return participant.revision = next_revision(participant.revision);
}

Status KeyFactory::revise(LocalEndpointCrypto& endpoint) {
  DDSSEC_ASSIGN_OR_RETURN(endpoint.next_submessage_key, revised(endpoint.submessage_key));
  DDSSEC_ASSIGN_OR_RETURN(endpoint.next_payload_key, revised(endpoint.payload_key));
  for (const auto& [participant, peer] : endpoint.peer_keys) {
    DDSSEC_ASSIGN_OR_RETURN(peer->next, revised(peer->key));
  }
  return {};
}

void KeyFactory::cancel_revision(LocalEndpointCrypto& endpoint) noexcept {
  endpoint.next_submessage_key.reset();
  endpoint.next_payload_key.reset();
  for (const auto& [participant, peer] : endpoint.peer_keys) peer->next.reset();
}

void KeyFactory::put_to_use(PublishedPointer<SendKey>& key, std::unique_ptr<SendKey>& next) {
  if (next) key.replace(std::move(next), state_.retired_objects);
}

void KeyFactory::activate_revision(LocalEndpointCrypto& endpoint) {
  put_to_use(endpoint.submessage_key, endpoint.next_submessage_key);
  put_to_use(endpoint.payload_key, endpoint.next_payload_key);
  for (const auto& [participant, peer] : endpoint.peer_keys) put_to_use(peer->key, peer->next);
}

Status KeyFactory::activate_key_revision(spi::ParticipantCryptoHandle local, KeyRevision revision) {
  const std::lock_guard lock(state_.mutex);
  DDSSEC_ASSIGN_OR_RETURN(const auto local_participant, state_.local_participant(local));
  auto& participant = *local_participant;
  if (!participant.is_revising || revision != participant.revision)
    return fail(Code::key_revision_out_of_turn,
                {.field = "key_revision", .found = std::to_string(revision)});
  put_to_use(participant.key, participant.next_key);
  each_endpoint(participant, [&](LocalEndpointCrypto& endpoint) { activate_revision(endpoint); });
  participant.is_revising = false;
  return {};
}

// ---- how long keys are in use

Status KeyFactory::limit_keys(LocalParticipantCrypto& participant,
                              const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto limits, spi::key_limits(properties));
  if (limits.any() && !participant.revises_keys) {
    const auto name = limits.blocks != 0 ? property::kMaxBlocksPerKey : property::kKeyLifetime;
    return fail(Code::key_limits_without_revision, {.field = std::string(name)});
  }
  participant.life = KeyLife(limits);
  return begin_life(participant);
}

bool KeyFactory::is_key_revision_due(spi::ParticipantCryptoHandle local) const {
  const std::lock_guard lock(state_.mutex);
  const auto found = state_.local_participant(local);
  if (!found || (*found)->is_revising) return false;
  const auto& life = (*found)->life;
  const auto now = state_.services.clock.monotonic();
  return life.has_ended(now) || (life.counts_blocks(now) && life.is_used_up(blocks_used(**found)));
}

std::uint64_t KeyFactory::blocks_used(const LocalParticipantCrypto& participant) const {
  const ReadGuard guard;  // a sending thread may go on to the next session
  std::uint64_t most = 0;
  const auto count = [&](const PublishedPointer<SendKey>& published) {
    if (const auto* const key = published.read()) most = std::max(most, key->blocks_used());
  };
  count(participant.key);
  each_endpoint(participant, [&](const LocalEndpointCrypto& endpoint) {
    count(endpoint.submessage_key);
    count(endpoint.payload_key);
    for (const auto& [remote, peer] : endpoint.peer_keys) count(peer->key);
  });
  return most;
}

// ---- former keys of peers

void KeyFactory::forget_former_keys() {
  const std::lock_guard lock(state_.mutex);
  const auto now = state_.services.clock.monotonic();
  std::erase_if(state_.former_until, [&](const auto& note) {
    if (now < note.second) return false;
    forget_former_keys(note.first, now);
    return true;
  });
}

void KeyFactory::forget_former_keys(std::int64_t handle, std::chrono::nanoseconds now) {
  const auto prune = [&](PublishedPointer<RemoteKeys>& keys) {
    if (const auto* const present = keys.read())
      keys.replace(without_ended(*present, now), state_.retired_objects);
  };
  if (const auto participant = state_.remote_participant(spi::ParticipantCryptoHandle{handle}))
    for (const auto& [local, pair] : (*participant)->pairs) prune(pair->remote_keys);
  for (const auto kind : {EntityKind::remote_writer, EntityKind::remote_reader})
    if (const auto endpoint = state_.registry.find<RemoteEndpointCrypto>(handle, kind))
      prune((*endpoint)->remote_keys);
}

}  // namespace ddssec::cryptography
