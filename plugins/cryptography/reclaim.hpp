// Reading shared objects without locks: a replaced object is destroyed when no thread can still
// hold it.
//
// Every reading thread has its own slot with the epoch at which it entered, 0 outside. A thread
// that replaces an object first unlinks it (a seq_cst store to the pointer that led to it), then
// retires it. The object is stamped with the epoch, which is then increased. It is destroyed once
// no slot holds an epoch up to its stamp. Why that is safe, with all operations named here
// sequentially consistent, hence in one total order S:
//
// - reader: (1) reads the epoch E, (2) stores E to its slot, (3) reads the pointer
// - replacer: (a) unlinks, (b) epoch r -> r + 1, (c) reads all slots
//
// If (c) does not see (2), then (c) precedes (2) in S, so does (a), and (3) finds the new object.
// If (c) sees E <= r, the object stays. If (c) sees E > r, then (1) followed (b), so (3) followed
// (a) and finds the new object. In no case does a reader hold a destroyed object.
//
// The message path therefore writes nothing that other threads write: one exchange and one store to
// its own cache line.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

namespace ddssec::cryptography {

/// While a guard lives, its thread may read shared objects. Guards do not nest.
class ReadGuard {
 public:
  /// The first guard of a thread allocates memory.
  ReadGuard();
  ~ReadGuard() { slot_.store(0, std::memory_order_release); }
  ReadGuard(const ReadGuard&) = delete;
  ReadGuard& operator=(const ReadGuard&) = delete;

 private:
  std::atomic<std::uint64_t>& slot_;
};

/// Base class of objects that can be retired.
class RetirableObject {
 public:
  RetirableObject() = default;
  virtual ~RetirableObject() = default;
  RetirableObject(const RetirableObject&) = delete;
  RetirableObject& operator=(const RetirableObject&) = delete;

 private:
  friend class RetiredObjects;
  std::unique_ptr<RetirableObject> retired_after_;
  std::uint64_t epoch_ = 0;
};

/// Returns a stamp for an object that was just unlinked: it may be destroyed, or used again, once
/// `is_safe`.
std::uint64_t retirement_epoch() noexcept;
/// True if no thread can still hold an object with that stamp.
bool is_safe(std::uint64_t epoch) noexcept;

/// Retired objects that wait for their readers. Its owner must outlive all readers of the objects.
/// Thread-safe.
class RetiredObjects {
 public:
  RetiredObjects() = default;
  ~RetiredObjects();
  RetiredObjects(const RetiredObjects&) = delete;
  RetiredObjects& operator=(const RetiredObjects&) = delete;

  /// Takes ownership of an unlinked object (or null), and frees objects that have become safe.
  /// Allocates no memory, so an unlinked object can always be kept for its readers.
  void retire(std::unique_ptr<RetirableObject> object) noexcept;
  /// Returns the number of objects that still wait.
  std::size_t size() const;

 private:
  std::unique_ptr<RetirableObject> take_reclaimable() noexcept;

  mutable std::mutex mutex_;
  std::unique_ptr<RetirableObject> first_;  ///< a list in the order of retirement
  RetirableObject* last_ = nullptr;
  std::size_t size_ = 0;
};

/// An owning pointer. Readers follow it under a ReadGuard while one writer at a time replaces it.
template <class T>
class PublishedPointer {
 public:
  PublishedPointer() = default;
  explicit PublishedPointer(std::unique_ptr<T> first) : pointer_(first.release()) {}
  ~PublishedPointer() { delete pointer_.load(); }
  PublishedPointer(const PublishedPointer&) = delete;
  PublishedPointer& operator=(const PublishedPointer&) = delete;

  /// Call it under a ReadGuard, or as the only writer.
  T* read() const noexcept { return pointer_.load(); }

  /// Publishes `next`; the former object is retired.
  void replace(std::unique_ptr<T> next, RetiredObjects& retired_objects) {
    std::unique_ptr<T> former(pointer_.exchange(next.release()));
    if (former) retired_objects.retire(std::move(former));
  }

  /// Publishes `next` and returns the unlinked former object, which others may still read.
  std::unique_ptr<T> exchange(std::unique_ptr<T> next) {
    return std::unique_ptr<T>(pointer_.exchange(next.release()));
  }

 private:
  std::atomic<T*> pointer_ = nullptr;
};

}  // namespace ddssec::cryptography
