#include "rtps/reliability/received_change.hpp"

#include "rtps/reliability/end_mark.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

// Key tokens arrive at the volatile secure endpoint, so their memory is wiped.
void wipe_if_secret(Change& change) {
  if (change.writer.entity == kVolatileMessageWriter) change.payload.wipe_at_end();
}

}  // namespace

Change received_change(const GuidPrefix& from, const Data& data, const std::optional<Time>& time,
                       Payload payload) {
  Change out{{from, data.writer},
             data.sequence_number,
             data.inline_qos.status,
             data.inline_qos.key_hash,
             time,
             data.kind == PayloadKind::key,
             std::move(payload),
             data.inline_qos.coherence,
             data.inline_qos.original};
  // The same end may also arrive from a writer that does not mark it.
  if (!out.is_alive()) set_end_mark(out.payload.fill(), 0);
  wipe_if_secret(out);
  return out;
}

Change received_change(const GuidPrefix& from, const DataFrag& frag,
                       const std::optional<Time>& time) {
  Change out{{from, frag.writer},
             frag.sequence_number,
             frag.inline_qos.status,
             frag.inline_qos.key_hash,
             time,
             frag.is_key,
             Payload::uninitialized(frag.sample_size),
             frag.inline_qos.coherence,
             frag.inline_qos.original};
  wipe_if_secret(out);
  return out;
}

}  // namespace ddssec::rtps
