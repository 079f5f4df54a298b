// Key-only payloads in a form that the matched readers can read.
#pragma once

#include <functional>

#include "base/bytes.hpp"

namespace ddssec::rtps {

/// How a peer's readers interpret the payload of a dispose or unregister.
struct KeyReading {
  /// Cyclone DDS up to 0.10 expects no DHEADER in the key of an appendable type.
  bool bare_only = false;
  /// Fast DDS up to 2.x interprets a payload of up to 16 octets as the key hash, whatever it
  /// contains.
  bool short_is_hash = false;

  bool operator==(const KeyReading&) const = default;
  KeyReading& operator|=(const KeyReading& other) {
    bare_only = bare_only || other.bare_only;
    short_is_hash = short_is_hash || other.short_is_hash;
    return *this;
  }
};

/// Converts a serialized key to the layout that such readers expect. Returns empty if it cannot be
/// read.
using KeyRewriter = std::function<Bytes(BytesView key)>;

/// Returns the key in a form that all of `readers` can read: `payload` itself, or a view of
/// `scratch`.
BytesView key_payload_for(const KeyReading& readers, BytesView payload, const KeyRewriter& to_bare,
                          Bytes& scratch);

}  // namespace ddssec::rtps
