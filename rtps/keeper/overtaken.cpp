#include "rtps/keeper/overtaken.hpp"

namespace ddssec::rtps {

void Overtaken::forget(const Guid& writer) {
  waiting_.erase(writer);
  returning_.erase(writer);
  if (waiting_.empty() && returning_.empty()) end_pass();
}

void Overtaken::end_pass() {
  returning_.clear();
  if (!waiting_.empty()) return;
  kept_.clear();
  order_.clear();
}

void Overtaken::note(const Change& kept) {
  if (waiting_.empty() && returning_.empty()) return;
  const auto key = kept.key_hash.value_or(KeyHash{});
  const Kept entry{kept.origin().writer, kept.source_time.value_or(Time{}), kept.status.disposed};
  if (const auto known = kept_.find(key); known != kept_.end()) {
    if (known->second.time <= entry.time) known->second = entry;
    return;
  }
  order_.push_back(key);
  kept_.emplace(key, entry);
  if (kept_.size() <= kMost) return;
  kept_.erase(order_.front());
  order_.pop_front();
}

bool Overtaken::is_overtaken(const Change& change, bool ends_only) const {
  if (!waiting_.contains(change.writer) && !returning_.contains(change.writer)) return false;
  const auto at = kept_.find(change.key_hash.value_or(KeyHash{}));
  if (at == kept_.end()) return false;
  const auto& kept = at->second;
  return change.source_time && kept.writer != change.origin().writer &&
         *change.source_time < kept.time && (kept.is_end || !ends_only);
}

}  // namespace ddssec::rtps
