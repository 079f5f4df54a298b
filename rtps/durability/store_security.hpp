// Keeps samples of a secured domain from being served in the clear.
#pragma once

#include "rtps/durability/durable_store.hpp"

namespace ddssec::rtps {

/// Checks that the store was kept by a participant of the same kind. Call it before any
/// other stream of the store is opened. A store remembers whether its samples were kept by a
/// secured participant; one of the other kind must not serve them. A store with samples that
/// remembers nothing counts as secured. `now` is the calendar time.
/// Errors: rtps_store_unusable (kept by the other kind), those of DurableStore::open_stream.
Status check_store_security(DurableStore& store, bool is_secured, Time now);

}  // namespace ddssec::rtps
