#include "rtps/durability/durable_stores.hpp"

#include "rtps/durability/store_security.hpp"

namespace ddssec::rtps {

Status DurableStores::open_file(const std::string& path, std::size_t max_octets, bool is_secured,
                                Time now) {
  DDSSEC_ASSIGN_OR_RETURN(persistent_, DurableStore::open(path, events_, max_octets, now));
  return check_store_security(*persistent_, is_secured, now);
}

Result<DurableStore*> DurableStores::of(DurabilityKind kind) {
  if (kind == DurabilityKind::persistent && persistent_) return persistent_.get();
  if (kind == DurabilityKind::persistent)
    events_.raise(Event(Error(Code::rtps_store_unusable,
                              {.document = "participant options",
                               .field = "durability_store",
                               .expected = "a path, for a writer with DURABILITY PERSISTENT",
                               .found = "none: its samples last as long as the participant"})));
  if (!transient_) {
    DDSSEC_ASSIGN_OR_RETURN(transient_, DurableStore::open("", events_, kMaxOctetsInMemory));
  }
  return transient_.get();
}

}  // namespace ddssec::rtps
