// DATA: one change of a writer (RTPS 9.4.5.3).
#pragma once

#include <cstdint>

#include "wire/inline_qos.hpp"
#include "wire/numbers.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

/// The content of the serialized payload: nothing, a sample, or the key of an instance that ends.
enum class PayloadKind : std::uint8_t { none, data, key };

/// One DATA submessage. Borrows its payload, which begins with its encapsulation (or is a protected
/// payload).
struct Data {
  EntityId reader;  ///< unknown means all of the writer's readers
  EntityId writer;
  SequenceNumber sequence_number{1};
  InlineQos inline_qos = {};
  PayloadKind kind = PayloadKind::none;
  BytesView payload = {};
};

/// Reads the submessage. Errors: truncated, rtps_number_invalid, rtps_submessage_overrun (the
/// offset to the inline QoS lies inside the fixed part or after the end), malformed (data and key
/// flags together), those of read_inline_qos.
Result<Data> read_data(const SubmessageView& view);
/// Writes the submessage. If it does not fit, out.overflowed() is true.
void write(SpanWriter& out, const Data& data);

}  // namespace ddssec::rtps
