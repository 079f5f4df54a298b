#include "rtps/dcps/data_reader.hpp"

namespace ddssec::rtps {

ReaderCore::ReaderCore(DomainParticipant& participant, const Qos& qos, KeyOf key_of)
    : participant_(participant),
      history_(qos.history),
      most_samples_(qos.resource_limits.max_samples == kLengthUnlimited
                        ? kMostSamples
                        : static_cast<std::size_t>(qos.resource_limits.max_samples)),
      key_of_(std::move(key_of)) {}

Result<std::unique_ptr<ReaderCore>> ReaderCore::create(DomainParticipant& participant,
                                                       Participant::EndpointRequest request,
                                                       KeyOf key_of) {
  std::unique_ptr<ReaderCore> out(new ReaderCore(participant, request.qos, std::move(key_of)));
  const std::lock_guard lock(participant.mutex_);
  out->guid_ =
      DDSSEC_TRY(participant.protocol_->create_reader(std::move(request), *out, participant.now()));
  participant.reschedule();
  return out;
}

ReaderCore::~ReaderCore() {
  const std::lock_guard lock(participant_.mutex_);
  participant_.protocol_->remove(guid_, participant_.now());
  participant_.reschedule();
}

std::optional<Change> ReaderCore::take_next() {
  const std::lock_guard lock(participant_.mutex_);
  if (samples_.empty()) return std::nullopt;
  auto change = std::move(samples_.front());
  samples_.pop_front();
  octets_ -= change.payload.size();
  return change;
}

bool ReaderCore::wait_for_data(std::chrono::nanoseconds most) {
  std::unique_lock lock(participant_.mutex_);
  return participant_.changed_.wait_for(lock, most, [&] { return !samples_.empty(); });
}

void ReaderCore::on_data(std::function<void()> callback) {
  const std::lock_guard lock(participant_.mutex_);
  on_data_ = std::move(callback);
}

MatchedStatus ReaderCore::matched() const {
  const std::lock_guard lock(participant_.mutex_);
  return matched_;
}

IncompatibleQosStatus ReaderCore::incompatible_qos() const {
  const std::lock_guard lock(participant_.mutex_);
  return incompatible_;
}

std::uint64_t ReaderCore::malformed() const { return malformed_; }

void ReaderCore::on_matched(const EndpointData& remote) {
  if (std::ranges::find(remotes_, remote.guid) != remotes_.end()) return;
  remotes_.push_back(remote.guid);
  ++matched_.total_count;
  ++matched_.current_count;
  matched_.last_remote = remote.guid;
  participant_.changed_.notify_all();
}

void ReaderCore::on_unmatched(const Guid& remote) {
  std::erase(remotes_, remote);
  --matched_.current_count;
  matched_.last_remote = remote;
  participant_.changed_.notify_all();
}

void ReaderCore::on_incompatible_qos(const Guid&, const QosMismatch& mismatch) {
  ++incompatible_.total_count;
  incompatible_.last = mismatch;
  participant_.changed_.notify_all();
}

// KEEP_LAST: the newest `depth` of each instance.
void ReaderCore::make_room_in_instance(const KeyHash& key) {
  const auto same = [&](const Change& held) { return held.key_hash.value_or(KeyHash{}) == key; };
  const auto count = std::ranges::count_if(samples_, same);
  if (count < history_.depth) return;
  const auto oldest = std::ranges::find_if(samples_, same);
  octets_ -= oldest->payload.size();
  samples_.erase(oldest);
}

bool ReaderCore::on_change(Change& change) {
  if (key_of_ && !change.key_hash) change.key_hash = key_of_(change);
  if (key_of_ && !change.key_hash) {
    ++malformed_;
    return true;
  }
  if (history_.kind == HistoryKind::keep_last)
    make_room_in_instance(change.key_hash.value_or(KeyHash{}));
  const auto size = change.payload.size();
  const bool room =
      samples_.size() < most_samples_ && (samples_.empty() || octets_ + size <= kMostOctets);
  if (!room) return false;
  octets_ += size;
  samples_.push_back(std::move(change));
  if (on_data_) on_data_();
  participant_.changed_.notify_all();
  return true;
}

}  // namespace ddssec::rtps
