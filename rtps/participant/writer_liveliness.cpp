#include "rtps/participant/writer_liveliness.hpp"

#include <algorithm>

#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

// The values of ParticipantMessageData::kind (RTPS 9.6.3.1) are the same octets for all vendors.
constexpr std::uint8_t kAutomatic = 1;
constexpr std::uint8_t kManualByParticipant = 2;
// The key consists of the GUID prefix and the kind.
constexpr std::size_t kKeySize = 16;

// Several assertions fit into the shortest lease, but a lease never causes more than one within
// kMinPeriod.
constexpr int kAssertionsPerLease = 3;
constexpr MonotonicTime kMinPeriod = std::chrono::milliseconds(1);

MonotonicTime period_of(MonotonicTime lease) {
  return std::max(lease / kAssertionsPerLease, kMinPeriod);
}

}  // namespace

WriterLiveliness::WriterLiveliness(ParticipantCore& core, LocalEndpoints& local,
                                   RemoteParticipants& remotes)
    : core_(core), local_(local), remotes_(remotes) {}

// The assertion need not be sent at once, because the leases of readers that match the writer later
// start when they match.
void WriterLiveliness::expect(const Liveliness& liveliness) {
  if (liveliness.kind != LivelinessKind::automatic || liveliness.lease_duration.is_infinite())
    return;
  next_assertion_ =
      std::min(next_assertion_, core_.now + period_of(liveliness.lease_duration.to_nanoseconds()));
}

void WriterLiveliness::tick() {
  if (core_.now >= next_assertion_) assert_liveliness(LivelinessKind::automatic);
}

void WriterLiveliness::assert_liveliness(LivelinessKind kind) {
  auto shortest = kNever;
  for (const auto& [id, local] : local_.writers()) {
    const auto& liveliness = local.data.qos.liveliness;
    if (liveliness.kind == kind && !liveliness.lease_duration.is_infinite())
      shortest = std::min(shortest, liveliness.lease_duration.to_nanoseconds());
  }
  if (kind == LivelinessKind::automatic)
    next_assertion_ = shortest == kNever ? kNever : core_.now + period_of(shortest);
  if (shortest == kNever || kind == LivelinessKind::manual_by_topic) return;
  note_alive(remotes_.self(), kind);
  KeyHash key{};
  std::ranges::copy(local_.prefix().octets, key.begin());
  key.back() = kind == LivelinessKind::automatic ? kAutomatic : kManualByParticipant;
  std::array<std::uint8_t, 32> buffer;
  SpanWriter payload(buffer);
  payload.write_bytes(std::array<std::uint8_t, 4>{0, 1, 0, 0});
  payload.write_bytes(key);
  payload.write(std::uint32_t{1});
  payload.write(std::uint32_t{0});
  Change change;
  change.key_hash = key;
  change.payload = Payload::copy_of(payload.view());
  const auto topic = core_.attributes().is_liveliness_protected()
                         ? BuiltinTopic::participant_message_secure
                         : BuiltinTopic::participant_message;
  local_.builtin().writer(topic).write(std::move(change), core_.now);
}

// Fast DDS labels the same octets PL_CDR. If liveliness is protected, only Cyclone DDS, which never
// uses the secure topic, may assert it by the unprotected topic.
void WriterLiveliness::on_participant_message(const Change& change, bool secure) {
  auto* remote = remotes_.find(change.writer.prefix);
  const auto opened = open_payload(change.payload.view());
  if (remote == nullptr || !change.is_alive() || !opened) return;
  const auto body = opened->body;
  if (body.size() < kKeySize || !std::ranges::equal(body.first(12), remote->prefix().octets))
    return;
  const bool must_be_secure =
      core_.security && core_.security->core().must_protect_liveliness(remote->prefix());
  if (must_be_secure && !secure && remote->data.vendor != kVendorCyclone) return;
  if (body[15] == kAutomatic) note_alive(*remote, LivelinessKind::automatic);
  if (body[15] == kManualByParticipant) note_alive(*remote, LivelinessKind::manual_by_participant);
}

void WriterLiveliness::note_alive(RemoteParticipant& remote, LivelinessKind kind) {
  if (const auto signal = remote.signal(kind)) signal->assert_at(core_.now);
}

// A writer of kind AUTOMATIC is alive as long as its participant is.
void WriterLiveliness::note_alive(const Guid& writer) {
  auto* remote = remotes_.find_or_self(writer.prefix);
  if (remote == nullptr) return;
  const auto endpoint = remote->endpoints.find(writer.entity);
  if (endpoint == remote->endpoints.end()) return;
  const auto kind = endpoint->second.data.qos.liveliness.kind;
  if (kind != LivelinessKind::manual_by_topic) return note_alive(*remote, kind);
  const auto readers = remote->watches.find(writer.entity);
  if (readers == remote->watches.end()) return;
  for (auto* reader : readers->second) reader->on_alive(writer);
}

}  // namespace ddssec::rtps
