// Key material of a kind, with recognizable keys.
#pragma once

#include "plugins/cryptography/key_material.hpp"

namespace ddssec::cryptography::testing {

inline KeyMaterial material(TransformKind kind, std::uint8_t id = 1, bool receiver = false) {
  const auto size = traits_of(kind)->key_size();
  KeyMaterial out{.kind = kind};
  out.salt = MasterSalt::copy_of(Bytes(size, 1)).value();
  out.sender_key_id = KeyId{{0, 0, 0, id}};
  out.sender_key = MasterKey::copy_of(Bytes(size, 2)).value();
  if (!receiver) return out;
  out.receiver_key_id = KeyId{{0, 0, 1, id}};
  out.receiver_key = MasterReceiverKey::copy_of(Bytes(size, 3)).value();
  return out;
}

}  // namespace ddssec::cryptography::testing
