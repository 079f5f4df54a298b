// Participant, the part that says and hears who lives (RTPS 8.4.13).
#include <algorithm>

#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {
namespace {

// ParticipantMessageData::kind (RTPS 9.6.3.1), the same octets for all vendors.
constexpr std::uint8_t kAutomatic = 1;
constexpr std::uint8_t kManualByParticipant = 2;
/// Prefix and kind.
constexpr std::size_t kKeySize = 16;

/// Several of them fit into the shortest lease.
constexpr int kAssertionsPerLease = 3;

}  // namespace

// It is asserted for those who match it later: they count from then.
void Participant::expect_liveliness_of(const Liveliness& liveliness, MonotonicTime now) {
  if (liveliness.kind != LivelinessKind::automatic || liveliness.lease_duration.is_infinite())
    return;
  const auto period = liveliness.lease_duration.to_nanoseconds() / kAssertionsPerLease;
  next_liveliness_ = std::min(next_liveliness_, now + period);
}

void Participant::assert_liveliness(LivelinessKind kind, MonotonicTime now) {
  now_ = now;
  auto shortest = kNever;
  for (const auto& [id, local] : writers_) {
    const auto& liveliness = local.data.qos.liveliness;
    if (liveliness.kind == kind && !liveliness.lease_duration.is_infinite())
      shortest = std::min(shortest, liveliness.lease_duration.to_nanoseconds());
  }
  if (kind == LivelinessKind::automatic)
    next_liveliness_ = shortest == kNever ? kNever : now + shortest / kAssertionsPerLease;
  if (shortest == kNever || kind == LivelinessKind::manual_by_topic) return;
  note_alive(self_, kind);
  KeyHash key{};
  std::ranges::copy(config_.prefix.octets, key.begin());
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
  const bool secure = security_ && security_->own().attributes().is_liveliness_protected();
  const auto topic =
      secure ? BuiltinTopic::participant_message_secure : BuiltinTopic::participant_message;
  builtin_.writer(topic).write(std::move(change), now);
}

// Fast DDS calls the same octets PL_CDR. Where liveliness is protected, only Cyclone DDS, which
// never uses the secure topic, may assert it by the plain one.
void Participant::on_participant_message(const Change& change, bool secure) {
  const auto remote = remotes_.find(change.writer.prefix);
  const auto opened = open_payload(change.payload.view());
  if (remote == remotes_.end() || !change.is_alive() || !opened) return;
  const auto body = opened->body;
  if (body.size() < kKeySize || !std::ranges::equal(body.first(12), remote->first.octets)) return;
  const bool must_be_secure = security_ && security_->own().attributes().is_liveliness_protected();
  if (must_be_secure && !secure && remote->second.data.vendor != kVendorCyclone) return;
  if (body[15] == kAutomatic) note_alive(remote->second, LivelinessKind::automatic);
  if (body[15] == kManualByParticipant)
    note_alive(remote->second, LivelinessKind::manual_by_participant);
}

}  // namespace ddssec::rtps
