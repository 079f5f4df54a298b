#include "plugins/cryptography/latest_iv.hpp"

namespace ddssec::cryptography {
namespace {

constexpr unsigned kBlockBits = 40, kSessionBits = 24;

template <class T>
T big_endian_at(const Iv& iv, std::size_t at) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = static_cast<T>(value << 8 | iv[at + i]);
  return value;
}

/// Moved into the middle of what so many bits can tell.
std::optional<std::uint64_t> centred(std::int64_t distance, unsigned bits) {
  const auto half = std::int64_t{1} << (bits - 1);
  if (distance <= -half || distance >= half) return std::nullopt;
  return static_cast<std::uint64_t>(distance + half);
}

}  // namespace

LatestIv::Position LatestIv::position_of(const Iv& iv) noexcept {
  return {big_endian_at<std::uint32_t>(iv, 0), big_endian_at<std::uint64_t>(iv, 4)};
}

LatestIv::Place LatestIv::latest() const noexcept {
  return has_order_.load(std::memory_order_relaxed) ? latest_.load(std::memory_order_relaxed) : 0;
}

std::optional<LatestIv::Place> LatestIv::place_of(const Iv& iv) const noexcept {
  if (!has_begun_.load(std::memory_order_acquire)) return std::nullopt;
  const auto at = position_of(iv);
  const auto session =
      centred(static_cast<std::int32_t>(at.session - first_.session), kSessionBits);
  const auto block = centred(static_cast<std::int64_t>(at.block - first_.block), kBlockBits);
  if (!session || !block) return std::nullopt;
  return *session << kBlockBits | *block;
}

void LatestIv::begin(const Position& first) noexcept {
  const std::lock_guard lock(beginning_);
  if (has_begun_.load(std::memory_order_relaxed)) return;
  first_ = first;
  has_begun_.store(true, std::memory_order_release);
}

void LatestIv::note(const Iv& iv) noexcept {
  if (!has_begun_.load(std::memory_order_acquire)) [[unlikely]]
    begin(position_of(iv));
  const auto place = place_of(iv);
  if (!place) [[unlikely]] {
    has_order_.store(false, std::memory_order_relaxed);
    return;
  }
  auto latest = latest_.load(std::memory_order_relaxed);
  while (*place > latest &&
         !latest_.compare_exchange_weak(latest, *place, std::memory_order_relaxed)) {
  }
}

std::shared_ptr<LatestIv> LatestIvs::of(const Subject& subject, const KeyMaterial& key) {
  auto& keys = subjects_[subject];
  const auto digest = key.sender_key.expose([&](BytesView sender_key) {
    return key.salt.expose([&](BytesView salt) {
      return sha256({key.kind.view(), key.sender_key_id.view(), sender_key, salt});
    });
  });
  if (const auto known = keys.by_digest.find(digest); known != keys.by_digest.end())
    return known->second;
  if (keys.by_digest.size() >= kMostOfSubject) {
    keys.by_digest.erase(keys.in_order.front());
    keys.in_order.pop_front();
  }
  auto added = std::make_shared<LatestIv>();
  keys.in_order.push_back(digest);
  keys.by_digest.emplace(digest, added);
  return added;
}

}  // namespace ddssec::cryptography
