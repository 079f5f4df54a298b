#include "plugins/cryptography/registry.hpp"

namespace ddssec::cryptography {

Registry::~Registry() {
  for (auto& chunk : chunks_) {
    const std::unique_ptr<Chunk> owned(chunk.load());
    if (!owned) continue;
    for (auto& one : *owned) delete one.entity.load();
  }
}

Registry::Place& Registry::place(std::uint64_t index) const {
  return (*chunks_[index / kChunkSize].load(std::memory_order_relaxed))[index % kChunkSize];
}

Status Registry::add(std::unique_ptr<CryptoEntity> entity) {
  if (free_.empty()) {
    if (next_ == kChunkSize * kMaxChunks) return fail(Code::crypto_too_many_entities);
    auto& chunk = chunks_[next_ / kChunkSize];
    if (chunk.load() == nullptr) {
      free_.reserve(next_ + kChunkSize);  // so that removal needs no memory
      chunk.store(std::make_unique<Chunk>().release());
    }
    free_.push_back(next_++);
  }
  const auto index = free_.back();
  free_.pop_back();
  auto& here = place(index);
  const auto generation = (first_generation_ + here.used++) & kGenerationMask;
  const auto kind = static_cast<std::uint64_t>(entity->kind());
  entity->handle_ = static_cast<std::int64_t>(kind << (kGenerationBits + kIndexBits) |
                                              generation << kIndexBits | index);
  here.entity.store(entity.release());
  ++size_;
  return {};
}

std::unique_ptr<CryptoEntity> Registry::remove(const CryptoEntity& entity) noexcept {
  const auto index = static_cast<std::uint64_t>(entity.handle()) & kIndexMask;
  std::unique_ptr<CryptoEntity> removed(place(index).entity.exchange(nullptr));
  free_.push_back(index);
  --size_;
  return removed;
}

std::unexpected<Error> Registry::handle_error(std::int64_t handle, const CryptoEntity* found) {
  if (handle == 0) return fail(Code::crypto_handle_nil);
  return fail(found != nullptr ? Code::crypto_handle_wrong_kind : Code::crypto_handle_unknown);
}

}  // namespace ddssec::cryptography
