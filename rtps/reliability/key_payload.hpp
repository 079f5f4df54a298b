// Key-only payloads as the matched readers can read them.
#pragma once

#include <functional>

#include "base/bytes.hpp"

namespace ddssec::rtps {

/// What a peer's readers make of the payload of a dispose or unregister.
struct KeyReading {
  /// Cyclone DDS up to 0.10 expects no DHEADER in the key of an appendable type.
  bool bare_only = false;
  /// Fast DDS up to 2.x takes a payload of up to 16 octets for the key hash, whatever it holds.
  bool short_is_hash = false;

  bool operator==(const KeyReading&) const = default;
  KeyReading& operator|=(const KeyReading& other) {
    bare_only = bare_only || other.bare_only;
    short_is_hash = short_is_hash || other.short_is_hash;
    return *this;
  }
};

/// A serialized key in the layout that such readers expect; empty if it cannot be read.
using KeyRewriter = std::function<Bytes(BytesView key)>;

/// `payload`, or what `scratch` then holds: the same key in a form that all of `readers` can read.
BytesView key_payload_for(const KeyReading& readers, BytesView payload, const KeyRewriter& to_bare,
                          Bytes& scratch);

}  // namespace ddssec::rtps
