#include <atomic>
#include <memory>
#include <new>

#include <openssl/evp.h>

#include "base/secret.hpp"
#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {
namespace {

template <auto Free>
struct Deleter {
  template <class T>
  void operator()(T* object) const noexcept {
    Free(object);
  }
};
using Context = std::unique_ptr<EVP_CIPHER_CTX, Deleter<EVP_CIPHER_CTX_free>>;
using Cipher = std::unique_ptr<EVP_CIPHER, Deleter<EVP_CIPHER_free>>;

/// A context with the key in it costs a third of a new one, but serves one thread at a time. Who
/// finds it taken makes a context of its own rather than wait.
struct OpensslKey {
  Context context;
  std::atomic_flag taken;
  Secret<struct AeadKeyTag, 32> key;
};
static_assert(sizeof(OpensslKey) <= kKeyStorage);

OpensslKey* key_in(KeyStorage storage) {
  return std::launder(static_cast<OpensslKey*>(static_cast<void*>(storage)));
}

class Openssl final : public AeadBackend {
 public:
  Openssl(Cipher gcm128, Cipher gcm256) : gcm128_(std::move(gcm128)), gcm256_(std::move(gcm256)) {}
  std::string_view name() const override { return "openssl"; }

 protected:
  bool expand(KeyStorage storage, BytesView key) const override {
    auto copy = Secret<struct AeadKeyTag, 32>::copy_of(key);
    if (!copy) return false;
    auto context = context_with(*copy);
    if (!context) return false;
    new (storage) OpensslKey{std::move(context), {}, std::move(*copy)};
    return true;
  }

  bool seal(KeyStorage storage, std::size_t, const SealRequest& request) const override {
    return with_context(*key_in(storage), [&](EVP_CIPHER_CTX* context) {
      int octets = 0;
      return start(context, request.iv, request.aad, 1) &&
             update(context, request.plain, request.out) &&
             EVP_EncryptFinal_ex(context, nullptr, &octets) == 1 &&
             EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, kTagSize, request.tag.data()) == 1;
    });
  }

  /// EVP compares the tag itself, so that the tag to return is the expected one, or none.
  bool open(KeyStorage storage, std::size_t, const OpenRequest& request,
            TagView expected) const override {
    std::array<std::uint8_t, kTagSize> tag;
    std::ranges::copy(expected, tag.begin());
    const bool right = with_context(*key_in(storage), [&](EVP_CIPHER_CTX* context) {
      int octets = 0;
      return start(context, request.iv, request.aad, 0) &&
             update(context, request.cipher, request.out) &&
             EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, kTagSize, tag.data()) == 1 &&
             EVP_DecryptFinal_ex(context, nullptr, &octets) == 1;
    });
    if (right) std::ranges::copy(expected, request.tag.begin());
    return right;
  }

  void destroy(KeyStorage storage) const noexcept override { std::destroy_at(key_in(storage)); }

 private:
  Context context_with(const Secret<struct AeadKeyTag, 32>& key) const {
    Context context(EVP_CIPHER_CTX_new());
    const auto* cipher = key.size() == 16 ? gcm128_.get() : gcm256_.get();
    const bool ready = context && key.expose([&](BytesView octets) {
      return EVP_EncryptInit_ex(context.get(), cipher, nullptr, octets.data(), nullptr) == 1;
    });
    return ready ? std::move(context) : nullptr;
  }

  template <class F>
  bool with_context(OpensslKey& key, F&& f) const {
    if (!key.taken.test_and_set(std::memory_order_acquire)) {
      const bool done = f(key.context.get());
      key.taken.clear(std::memory_order_release);
      return done;
    }
    const auto own = context_with(key.key);
    return own && f(own.get());
  }

  static bool start(EVP_CIPHER_CTX* context, const Iv& iv, BytesView aad, int encrypt) {
    return EVP_CipherInit_ex(context, nullptr, nullptr, nullptr, iv.data(), encrypt) == 1 &&
           update(context, aad, nullptr);
  }

  /// EVP counts octets in int; longer inputs go in pieces.
  static bool update(EVP_CIPHER_CTX* context, BytesView in, std::uint8_t* out) {
    constexpr std::size_t kPiece = std::size_t{1} << 30;
    while (!in.empty()) {
      const auto piece = in.first(std::min(in.size(), kPiece));
      int octets = 0;
      if (EVP_CipherUpdate(context, out, &octets, piece.data(), static_cast<int>(piece.size())) !=
          1)
        return false;
      if (out != nullptr) out += piece.size();
      in = in.subspan(piece.size());
    }
    return true;
  }

  Cipher gcm128_;
  Cipher gcm256_;
};

}  // namespace

const AeadBackend* openssl_backend() {
  static const auto kBackend = []() -> std::unique_ptr<const AeadBackend> {
    Cipher gcm128(EVP_CIPHER_fetch(nullptr, "AES-128-GCM", nullptr));
    Cipher gcm256(EVP_CIPHER_fetch(nullptr, "AES-256-GCM", nullptr));
    if (!gcm128 || !gcm256) return nullptr;
    return std::make_unique<Openssl>(std::move(gcm128), std::move(gcm256));
  }();
  return kBackend.get();
}

}  // namespace ddssec::cryptography
