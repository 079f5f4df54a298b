#include "rtps/dcps/writer_instances.hpp"

#include "rtps/dcps/deadline.hpp"

namespace ddssec::rtps {

WriterInstances::WriterInstances(const Qos& qos)
    : max_(qos.resource_limits.max_instances == kLengthUnlimited
               ? kMaxInstances
               : static_cast<std::size_t>(qos.resource_limits.max_instances)),
      deadline_(deadline_period(qos.deadline)) {}

InstanceHandle WriterInstances::enter(const KeyHash& key,
                                      const std::function<Bytes()>& serialized_key) {
  if (const auto known = lookup(key); !known.is_nil()) return known;
  if (by_key_.size() >= max_) return {};
  auto& instance = by_key_[key];
  instance.handle = {next_handle_++};
  if (serialized_key) instance.key_value = serialized_key();
  by_handle_[instance.handle] = &instance;
  return instance.handle;
}

InstanceHandle WriterInstances::lookup(const KeyHash& key) const {
  const auto at = by_key_.find(key);
  return at == by_key_.end() ? InstanceHandle{} : at->second.handle;
}

const Bytes* WriterInstances::key_value(InstanceHandle instance) const {
  const auto at = by_handle_.find(instance);
  return at == by_handle_.end() ? nullptr : &at->second->key_value;
}

std::vector<std::pair<KeyHash, Bytes>> WriterInstances::keys() const {
  std::vector<std::pair<KeyHash, Bytes>> out;
  for (const auto& [key, instance] : by_key_) out.emplace_back(key, instance.key_value);
  return out;
}

void WriterInstances::remove(const KeyHash& key) {
  const auto at = by_key_.find(key);
  if (at == by_key_.end()) return;
  by_handle_.erase(at->second.handle);
  by_key_.erase(at);
}

void WriterInstances::note_written(const KeyHash& key, MonotonicTime now) {
  if (deadline_ == kNever) return;
  const auto at = by_key_.find(key);
  if (at == by_key_.end()) return;
  at->second.deadline = now + deadline_;
  at->second.due.append_to(due_);
}

void WriterInstances::note_disposed(const KeyHash& key) {
  if (const auto at = by_key_.find(key); at != by_key_.end()) at->second.due.leave();
}

void WriterInstances::expire_deadlines(MonotonicTime now,
                                       const std::function<void(InstanceHandle)>& missed) {
  while (!due_.empty() && due_.front()->deadline <= now) {
    auto& instance = *due_.front();
    instance.deadline = now + deadline_;
    instance.due.append_to(due_);
    missed(instance.handle);
  }
}

MonotonicTime WriterInstances::next_deadline() const {
  return due_.empty() ? kNever : due_.front()->deadline;
}

void WriterInstances::set_deadline(Duration period, MonotonicTime now) {
  const bool had_none = deadline_ == kNever;
  deadline_ = deadline_period(period);
  for (auto& [key, instance] : by_key_) {
    const bool expected = had_none || instance.due.linked();
    instance.due.leave();
    if (expected && deadline_ != kNever) note_written(key, now);
  }
}

}  // namespace ddssec::rtps
