// Handles and the entities that they stand for.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/result.hpp"
#include "plugins/cryptography/reclaim.hpp"

namespace ddssec::cryptography {

/// The kind of an entity.
enum class EntityKind : std::uint8_t {
  local_participant = 1,
  remote_participant,
  local_writer,
  remote_writer,
  local_reader,
  remote_reader,
};

/// An object with a handle. The registry assigns the handle, which never changes.
class CryptoEntity : public RetirableObject {
 public:
  explicit CryptoEntity(EntityKind kind) : kind_(kind) {}
  EntityKind kind() const { return kind_; }
  std::int64_t handle() const { return handle_; }

 private:
  friend class Registry;
  const EntityKind kind_;
  std::int64_t handle_ = 0;
};

/// Assigns handles and finds entities by them without a lock. A handle consists of, from the
/// highest bit: 0, kind (3 bits), generation (36 bits), index (24 bits). Generations start at
/// random, so that handles of another plugin and returned handles are unknown. The chunks that
/// indices point into never move.
class Registry {
 public:
  static constexpr std::size_t kChunkSize = 1024;
  static constexpr std::size_t kMaxChunks = 1024;

  explicit Registry(std::uint64_t first_generation)
      : first_generation_(first_generation & kGenerationMask) {}
  ~Registry();
  Registry(const Registry&) = delete;
  Registry& operator=(const Registry&) = delete;

  /// Assigns the entity its handle and takes ownership. One caller at a time. Error:
  /// crypto_too_many_entities.
  Status add(std::unique_ptr<CryptoEntity> entity);
  /// Unlinks the entity and returns it; afterwards its handle is unknown. The caller retires the
  /// entity. Allocates no memory. One caller at a time.
  std::unique_ptr<CryptoEntity> remove(const CryptoEntity& entity) noexcept;

  /// Returns the entity with that handle and kind. Under a ReadGuard, or by the one caller of
  /// `add`. Errors: crypto_handle_nil, crypto_handle_unknown (never given out, or returned),
  /// crypto_handle_wrong_kind.
  template <class T>
  Result<T*> find(std::int64_t handle, EntityKind kind) const {
    CryptoEntity* const entity = at(handle);
    if (entity != nullptr && entity->kind() == kind) [[likely]]
      return static_cast<T*>(entity);
    return handle_error(handle, entity);
  }
  std::size_t size() const { return size_; }

 private:
  static constexpr unsigned kIndexBits = 24;
  static constexpr unsigned kGenerationBits = 36;
  static constexpr std::uint64_t kIndexMask = (std::uint64_t{1} << kIndexBits) - 1;
  static constexpr std::uint64_t kGenerationMask = (std::uint64_t{1} << kGenerationBits) - 1;

  struct Place {
    std::atomic<CryptoEntity*> entity = nullptr;
    std::uint64_t used = 0;  // how often it was used; only the caller of add reads it
  };
  using Chunk = std::array<Place, kChunkSize>;

  /// Returns the live entity of exactly this handle, or nullptr.
  CryptoEntity* at(std::int64_t handle) const noexcept {
    const auto index = static_cast<std::uint64_t>(handle) & kIndexMask;
    if (handle <= 0 || index >= kChunkSize * kMaxChunks) return nullptr;
    const Chunk* const chunk = chunks_[index / kChunkSize].load(std::memory_order_acquire);
    if (chunk == nullptr) return nullptr;
    CryptoEntity* const entity = (*chunk)[index % kChunkSize].entity.load();
    return entity != nullptr && entity->handle_ == handle ? entity : nullptr;
  }
  Place& place(std::uint64_t index) const;
  static std::unexpected<Error> handle_error(std::int64_t handle, const CryptoEntity* found);

  const std::uint64_t first_generation_;
  std::array<std::atomic<Chunk*>, kMaxChunks> chunks_ = {};
  std::vector<std::uint64_t> free_;
  std::uint64_t next_ = 0;
  std::size_t size_ = 0;
};

}  // namespace ddssec::cryptography
