#include <atomic>
#include <memory>
#include <new>

#include <openssl/evp.h>

#include "base/deleter.hpp"
#include "base/secret.hpp"
#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {
namespace {

using Context = std::unique_ptr<EVP_CIPHER_CTX, Deleter<EVP_CIPHER_CTX_free>>;
using Fetched = std::unique_ptr<EVP_CIPHER, Deleter<EVP_CIPHER_free>>;

// Reusing a context that holds the key takes a third of the time of a new one, but only one thread
// at a time can use it. A thread that finds it in use creates its own context rather than wait.
struct OpensslKey {
  Context context;
  const EVP_CIPHER* cipher;
  std::atomic_flag taken;
  Secret<struct AeadKeyTag, 32> key;
};
static_assert(sizeof(OpensslKey) <= kKeyStorage);

OpensslKey* key_in(KeyStorage storage) {
  return std::launder(static_cast<OpensslKey*>(static_cast<void*>(storage)));
}

class Openssl final : public AeadBackend {
 public:
  Openssl(Fetched gcm128, Fetched gcm256, Fetched chacha)
      : gcm128_(std::move(gcm128)), gcm256_(std::move(gcm256)), chacha_(std::move(chacha)) {}
  std::string_view name() const override { return "openssl"; }
  bool has(Cipher cipher) const override { return fetched(cipher) != nullptr; }

 protected:
  bool expand(KeyStorage storage, Cipher cipher, BytesView key) const override {
    const auto* const implementation = fetched(cipher);
    if (implementation == nullptr) return false;
    auto copy = Secret<struct AeadKeyTag, 32>::copy_of(key);
    if (!copy) return false;
    auto context = context_with(implementation, *copy);
    if (!context) return false;
    new (storage) OpensslKey{std::move(context), implementation, {}, std::move(*copy)};
    return true;
  }

  bool seal(KeyStorage storage, Cipher, const SealRequest& request) const override {
    return with_context(*key_in(storage), [&](EVP_CIPHER_CTX* context) {
      int octets = 0;
      return start(context, request.iv, request.aad, Direction::encrypt) &&
             update(context, request.plain, request.out) &&
             EVP_EncryptFinal_ex(context, nullptr, &octets) == 1 &&
             EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_GET_TAG, kTagSize, request.tag.data()) == 1;
    });
  }

  // EVP compares the tag itself. The tag to return is therefore the expected one on success. On
  // failure none is written.
  bool open(KeyStorage storage, Cipher, const OpenRequest& request,
            TagView expected) const override {
    std::array<std::uint8_t, kTagSize> tag;
    std::ranges::copy(expected, tag.begin());
    const bool right = with_context(*key_in(storage), [&](EVP_CIPHER_CTX* context) {
      int octets = 0;
      return start(context, request.iv, request.aad, Direction::decrypt) &&
             update(context, request.cipher, request.out) &&
             EVP_CIPHER_CTX_ctrl(context, EVP_CTRL_AEAD_SET_TAG, kTagSize, tag.data()) == 1 &&
             EVP_DecryptFinal_ex(context, nullptr, &octets) == 1;
    });
    if (right) std::ranges::copy(expected, request.tag.begin());
    return right;
  }

  void destroy(KeyStorage storage) const noexcept override { std::destroy_at(key_in(storage)); }

 private:
  const EVP_CIPHER* fetched(Cipher cipher) const {
    if (cipher == Cipher::chacha20_poly1305) return chacha_.get();
    return cipher == Cipher::aes128_gcm ? gcm128_.get() : gcm256_.get();
  }

  static Context context_with(const EVP_CIPHER* cipher, const Secret<struct AeadKeyTag, 32>& key) {
    Context context(EVP_CIPHER_CTX_new());
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
    const auto own = context_with(key.cipher, key.key);
    return own && f(own.get());
  }

  // The numbers are those of EVP_CipherInit_ex().
  enum class Direction : int { decrypt = 0, encrypt = 1 };
  static bool start(EVP_CIPHER_CTX* context, const Iv& iv, BytesView aad, Direction direction) {
    return EVP_CipherInit_ex(context, nullptr, nullptr, nullptr, iv.data(),
                             static_cast<int>(direction)) == 1 &&
           update(context, aad, nullptr);
  }

  // EVP takes lengths as int, so longer inputs are processed in pieces.
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

  Fetched gcm128_;
  Fetched gcm256_;
  Fetched chacha_;  // nullptr if the provider does not have it
};

}  // namespace

const AeadBackend* openssl_backend() {
  // This object is never freed, because threads may outlive static objects.
  static const AeadBackend* const kBackend = []() -> const AeadBackend* {
    Fetched gcm128(EVP_CIPHER_fetch(nullptr, "AES-128-GCM", nullptr));
    Fetched gcm256(EVP_CIPHER_fetch(nullptr, "AES-256-GCM", nullptr));
    Fetched chacha(EVP_CIPHER_fetch(nullptr, "ChaCha20-Poly1305", nullptr));
    if (!gcm128 || !gcm256) return nullptr;
    return new Openssl(std::move(gcm128), std::move(gcm256), std::move(chacha));
  }();
  return kBackend;
}

}  // namespace ddssec::cryptography
