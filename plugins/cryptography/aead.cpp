#include "plugins/cryptography/aead.hpp"

#include <vector>

#include "base/hash.hpp"
#include "base/never_destroyed.hpp"
#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {

std::span<const AeadBackend* const> aead_backends() {
  static const NeverDestroyed<std::vector<const AeadBackend*>> kAvailable([] {
    std::vector<const AeadBackend*> list = {ipsec_mb_backend(), openssl_backend()};
    std::erase(list, nullptr);
    return list;
  }());
  return *kAvailable;
}

const AeadBackend* aead_backend(AeadChoice choice) {
  const auto available = aead_backends();
  switch (choice) {
    case AeadChoice::ipsec_mb:
      return ipsec_mb_backend();
    case AeadChoice::openssl:
      return openssl_backend();
    case AeadChoice::automatic:
      return available.empty() ? nullptr : available.front();
  }
  return nullptr;
}

Status ExpandedKey::expand(const AeadBackend& backend, Cipher cipher, BytesView key) {
  if (key.size() != key_size_of(cipher)) return fail(Code::length_out_of_range);
  clear();
  if (!backend.expand(storage_.data(), cipher, key)) return fail(Code::internal);
  backend_ = &backend;
  cipher_ = cipher;
  return {};
}

bool ExpandedKey::seal(const SealRequest& request) const {
  return backend_ != nullptr && backend_->seal(storage_.data(), cipher_, request);
}

bool ExpandedKey::open(const Iv& iv, BytesView aad, BytesView cipher, std::uint8_t* out,
                       TagView tag) const {
  if (backend_ == nullptr) return false;
  std::array<std::uint8_t, kTagSize> computed{};
  const OpenRequest request{iv, aad, cipher, out, computed};
  const bool opened = backend_->open(storage_.data(), cipher_, request, tag);
  // Implementations write plaintext before the tag is verified.
  if (opened && constant_time_equal(computed, tag)) [[likely]]
    return true;
  if (!cipher.empty()) wipe({out, cipher.size()});
  wipe(computed);
  return false;
}

bool ExpandedKey::mac(const Iv& iv, BytesView data, TagOut tag) const {
  return seal({iv, data, {}, nullptr, tag});
}

bool ExpandedKey::verify(const Iv& iv, BytesView data, TagView tag) const {
  std::array<std::uint8_t, kTagSize> computed{};
  const bool same = mac(iv, data, computed) && constant_time_equal(computed, tag);
  if (!same) wipe(computed);  // a valid tag for a forged message
  return same;
}

void ExpandedKey::clear() noexcept {
  if (backend_ == nullptr) return;
  backend_->destroy(storage_.data());
  wipe({static_cast<std::uint8_t*>(static_cast<void*>(storage_.data())), storage_.size()});
  backend_ = nullptr;
}

}  // namespace ddssec::cryptography
