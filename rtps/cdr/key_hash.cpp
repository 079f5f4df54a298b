#include "rtps/cdr/key_hash.hpp"

namespace ddssec::rtps::detail {

KeyHash key_hash_of(BytesView big_endian_key, bool always_md5) {
  if (always_md5 || big_endian_key.size() > 16) return md5(big_endian_key);
  KeyHash hash{};
  std::ranges::copy(big_endian_key, hash.begin());
  return hash;
}

}  // namespace ddssec::rtps::detail
