// The stores of one participant: a file for DURABILITY PERSISTENT, memory for TRANSIENT.
#pragma once

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

/// Opens the stores when they are needed. The caller serializes calls. The stores are destroyed
/// with this object.
class DurableStores {
 public:
  static constexpr std::size_t kMaxOctetsInMemory = std::size_t{256} << 20;

  /// `events` must outlive this object.
  explicit DurableStores(EventSink& events) : events_(events) {}

  /// Opens the file for PERSISTENT. `is_secured` says whether the participant is secured, and `now`
  /// is the calendar time. Errors: those of DurableStore::open and of check_store_security.
  Status open_file(const std::string& path, std::size_t max_octets, bool is_secured, Time now);
  /// Returns the store for writers of this kind, TRANSIENT or PERSISTENT. Without a file,
  /// PERSISTENT samples are kept in memory, which an event reports. Errors: those of
  /// DurableStore::open.
  Result<DurableStore*> of(DurabilityKind kind);

 private:
  EventSink& events_;
  std::unique_ptr<DurableStore> persistent_, transient_;
};

}  // namespace ddssec::rtps
