#include "rtps/reliability/contradictions.hpp"

#include <algorithm>

#include "base/hash.hpp"

namespace ddssec::rtps {
namespace {

// The content of every change in fragments. A writer that sends a change in fragments always does
// so.
constexpr std::uint64_t kInFragments = 0;

// Returns a number for the parts of a change that a reader of announcements makes use of.
std::uint64_t content_of(const Data& data) {
  const auto& qos = data.inline_qos;
  const std::array<std::uint8_t, 4> flags = {
      std::uint8_t{qos.status.disposed}, std::uint8_t{qos.status.unregistered},
      static_cast<std::uint8_t>(data.kind), std::uint8_t{qos.key_hash.has_value()}};
  const auto key = qos.key_hash.value_or(KeyHash{});
  const auto digest = sha256({flags, key, data.payload});
  std::uint64_t out = 0;
  for (std::size_t i = 0; i < sizeof(out); ++i) out = out << 8 | digest[i];
  return std::max<std::uint64_t>(out, kInFragments + 1);
}

}  // namespace

bool Contradictions::note(const Data& data, SequenceNumber next) {
  return note(data.sequence_number, content_of(data), next);
}

bool Contradictions::note(const DataFrag& frag, SequenceNumber next) {
  return note(frag.sequence_number, kInFragments, next);
}

// A change that was given up because of a forged GAP or HEARTBEAT has no content. Nor has one that
// is forgotten, but a writer seldom repeats changes that are so old.
bool Contradictions::note(SequenceNumber number, std::uint64_t content, SequenceNumber next) {
  const auto known = contents_.find(number);
  if (known != contents_.end()) return known->second != content;
  if (number < next) return true;
  highest_ = std::max(highest_, number);
  contents_.emplace(number, content);
  if (contents_.size() > kMaxRemembered) contents_.erase(contents_.begin());
  return false;
}

bool Contradictions::note(const Heartbeat& heartbeat) {
  const bool contradicts = heartbeat.last < highest_;
  highest_ = std::max({highest_, heartbeat.last, heartbeat.first.previous()});
  return contradicts;
}

void Contradictions::note(const Gap& gap) {
  highest_ = std::max(highest_, gap.list.base().previous());
  gap.list.for_each([&](SequenceNumber number) { highest_ = std::max(highest_, number); });
}

}  // namespace ddssec::rtps
