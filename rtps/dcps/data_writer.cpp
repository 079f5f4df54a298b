#include "rtps/dcps/data_writer.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::chrono::nanoseconds kBrake = std::chrono::milliseconds(20);

}  // namespace

Result<std::unique_ptr<WriterCore>> WriterCore::create(DomainParticipant& participant,
                                                       Participant::EndpointRequest request) {
  std::unique_ptr<WriterCore> out(new WriterCore(participant));
  out->max_blocking_time_ = request.qos.reliability.max_blocking_time.to_nanoseconds();
  const std::lock_guard lock(participant.mutex_);
  out->guid_ =
      DDSSEC_TRY(participant.protocol_->create_writer(std::move(request), *out, participant.now()));
  participant.reschedule();
  return out;
}

WriterCore::~WriterCore() {
  const std::lock_guard lock(participant_.mutex_);
  participant_.protocol_->remove(guid_, participant_.now());
  participant_.reschedule();
}

Status WriterCore::write(BytesView payload, const std::optional<KeyHash>& key, StatusInfo status,
                         bool key_only) {
  std::unique_lock lock(participant_.mutex_);
  auto& protocol = *participant_.protocol_->writer(guid_);
  const auto room = [&] { return protocol.has_room(payload.size()); };
  if (!room() && !participant_.changed_.wait_for(lock, max_blocking_time_, room))
    return fail(Code::rtps_history_full, {.document = "writer " + guid_.to_string()});
  // A gentle brake: what does not fit the receiver's buffers would be sent twice.
  if (protocol.is_ahead())
    participant_.changed_.wait_for(lock, std::min(max_blocking_time_, kBrake),
                                   [&] { return !protocol.is_ahead(); });
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  Change change;
  change.status = status;
  change.key_hash = key;
  change.source_time = Time::from(wall);
  change.key_only = key_only;
  change.payload = Payload::copy_of(payload);
  protocol.write(std::move(change), participant_.now());
  participant_.reschedule();
  return {};
}

MatchedStatus WriterCore::matched() const {
  const std::lock_guard lock(participant_.mutex_);
  return matched_;
}

IncompatibleQosStatus WriterCore::incompatible_qos() const {
  const std::lock_guard lock(participant_.mutex_);
  return incompatible_;
}

bool WriterCore::wait_for_acknowledgments(std::chrono::nanoseconds most) {
  std::unique_lock lock(participant_.mutex_);
  const auto& protocol = *participant_.protocol_->writer(guid_);
  return participant_.changed_.wait_for(lock, most, [&] { return protocol.all_acknowledged(); });
}

void WriterCore::on_matched(const EndpointData& remote) {
  if (std::ranges::find(remotes_, remote.guid) != remotes_.end()) return;
  remotes_.push_back(remote.guid);
  ++matched_.total_count;
  ++matched_.current_count;
  matched_.last_remote = remote.guid;
  participant_.changed_.notify_all();
}

void WriterCore::on_unmatched(const Guid& remote) {
  std::erase(remotes_, remote);
  --matched_.current_count;
  matched_.last_remote = remote;
  participant_.changed_.notify_all();
}

void WriterCore::on_incompatible_qos(const Guid&, const QosMismatch& mismatch) {
  ++incompatible_.total_count;
  incompatible_.last = mismatch;
  participant_.changed_.notify_all();
}

void WriterCore::on_acknowledged() { participant_.changed_.notify_all(); }

}  // namespace ddssec::rtps
