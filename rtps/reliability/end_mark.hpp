// A mark in the payload that ends an instance, for readers to which only payloads are proven.
#pragma once

#include "base/bytes.hpp"
#include "wire/inline_qos.hpp"

namespace ddssec::rtps {

/// Returns the mark of a change, or 0 if the change does not end its instance. The inline QoS says
/// whether a change ends an instance, and a flag says whether its payload is a key. Where only
/// payloads are protected, anyone can change both, and so let a sample that was overheard end its
/// instance. So our writers repeat them in the options of the encapsulation, which are part of the
/// payload (XTypes 1.3, clause 7.6.3.1.2). Readers of all vendors ignore these bits.
std::uint8_t end_mark(const StatusInfo& status, bool is_key_only);
/// True if the payload has this mark.
bool has_end_mark(BytesView payload, std::uint8_t mark);
/// Sets the mark of a payload, which begins with its encapsulation. No effect if it is too short.
void set_end_mark(MutableBytes payload, std::uint8_t mark);

}  // namespace ddssec::rtps
