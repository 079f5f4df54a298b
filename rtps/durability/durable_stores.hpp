// The stores of one participant: for DURABILITY PERSISTENT a file, for TRANSIENT memory.
#pragma once

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

/// The caller serializes calls. The stores die with it.
class DurableStores {
 public:
  static constexpr std::size_t kMaxOctetsInMemory = std::size_t{256} << 20;

  /// `events` outlives it.
  explicit DurableStores(EventSink& events) : events_(events) {}

  /// The file for PERSISTENT. Errors: those of DurableStore::open.
  Status open_file(const std::string& path, std::size_t most_octets);
  /// The store for writers of this kind, TRANSIENT or PERSISTENT. Without a file PERSISTENT samples
  /// are kept in memory, which an event says. Errors: those of DurableStore::open.
  Result<DurableStore*> of(DurabilityKind kind);

 private:
  EventSink& events_;
  std::unique_ptr<DurableStore> persistent_, transient_;
};

}  // namespace ddssec::rtps
