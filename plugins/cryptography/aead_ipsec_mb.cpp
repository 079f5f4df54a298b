#include <cstring>
#include <memory>

#include <intel-ipsec-mb.h>

#include "base/hash.hpp"
#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {
namespace {

static_assert(sizeof(gcm_key_data) <= kKeyStorage);

struct ManagerDeleter {
  void operator()(IMB_MGR* manager) const noexcept { free_mb_mgr(manager); }
};
using Manager = std::unique_ptr<IMB_MGR, ManagerDeleter>;

gcm_key_data* ipsec_mb_key_in(KeyStorage storage) {
  return static_cast<gcm_key_data*>(static_cast<void*>(storage));
}

// Working memory for one message, wiped afterwards: it contains the one-time key of the MAC and key
// stream.
template <class Data>
struct WipedContext {
  Data data;
  ~WipedContext() { wipe({static_cast<std::uint8_t*>(static_cast<void*>(&data)), sizeof data}); }
};
using GcmContext = WipedContext<gcm_context_data>;
using ChachaContext = WipedContext<chacha20_poly1305_context_data>;

// Uses the direct calls: one or three for each message. They have no state except the key, which
// they only read.
class IpsecMb final : public AeadBackend {
 public:
  explicit IpsecMb(Manager manager) : manager_(std::move(manager)) {}
  std::string_view name() const override { return "ipsec-mb"; }
  bool has(Cipher) const override { return true; }

 protected:
  bool expand(KeyStorage storage, Cipher cipher, BytesView key) const override {
    if (cipher == Cipher::chacha20_poly1305) {
      std::memcpy(storage, key.data(), key.size());
      return true;
    }
    auto* const place = new (storage) gcm_key_data;
    (cipher == Cipher::aes128_gcm ? manager_->gcm128_pre : manager_->gcm256_pre)(key.data(), place);
    return true;
  }

  bool seal(KeyStorage storage, Cipher cipher, const SealRequest& request) const override {
    if (cipher == Cipher::chacha20_poly1305) {
      chacha(storage, request, request.plain, manager_->chacha20_poly1305_enc_update);
      return true;
    }
    GcmContext context;
    (cipher == Cipher::aes128_gcm ? manager_->gcm128_enc : manager_->gcm256_enc)(
        ipsec_mb_key_in(storage), &context.data, request.out, request.plain.data(),
        request.plain.size(), request.iv.data(), request.aad.data(), request.aad.size(),
        request.tag.data(), kTagSize);
    return true;
  }

  bool open(KeyStorage storage, Cipher cipher, const OpenRequest& request, TagView) const override {
    if (cipher == Cipher::chacha20_poly1305) {
      chacha(storage, request, request.cipher, manager_->chacha20_poly1305_dec_update);
      return true;
    }
    GcmContext context;
    (cipher == Cipher::aes128_gcm ? manager_->gcm128_dec : manager_->gcm256_dec)(
        ipsec_mb_key_in(storage), &context.data, request.out, request.cipher.data(),
        request.cipher.size(), request.iv.data(), request.aad.data(), request.aad.size(),
        request.tag.data(), kTagSize);
    return true;
  }

  void destroy(KeyStorage) const noexcept override {}

 private:
  template <class Request>
  void chacha(KeyStorage key, const Request& request, BytesView in,
              chacha_poly_enc_dec_update_t update) const {
    ChachaContext context;
    manager_->chacha20_poly1305_init(key, &context.data, request.iv.data(), request.aad.data(),
                                     request.aad.size());
    if (!in.empty()) update(key, &context.data, request.out, in.data(), in.size());
    manager_->chacha20_poly1305_finalize(&context.data, request.tag.data(), kTagSize);
  }

  Manager manager_;
};

// Up to version 1.5 the library emulates AES without AES-NI, slower than OpenSSL. Version 2.0 has
// no emulation.
#if IMB_VERSION_NUM < IMB_VERSION(2, 0, 0)
constexpr auto kWithoutAes = IMB_ARCH_NOAESNI;
#else
constexpr auto kWithoutAes = IMB_ARCH_NONE;
#endif

Manager usable_manager() {
  Manager manager(alloc_mb_mgr(0));
  if (!manager) return nullptr;
  IMB_ARCH architecture = IMB_ARCH_NONE;
  init_mb_mgr_auto(manager.get(), &architecture);
  const bool aes_in_hardware =
      (manager->features & IMB_FEATURE_AESNI) != 0 && architecture != kWithoutAes;
  const bool broken = (manager->features & IMB_FEATURE_SELF_TEST) != 0 &&
                      (manager->features & IMB_FEATURE_SELF_TEST_PASS) == 0;
  if (imb_get_errno(manager.get()) != 0 || !aes_in_hardware || broken) return nullptr;
  return manager;
}

}  // namespace

const AeadBackend* ipsec_mb_backend() {
  // This object is never freed, because threads may outlive static objects.
  static const AeadBackend* const kBackend = []() -> const AeadBackend* {
    auto manager = usable_manager();
    return manager ? new IpsecMb(std::move(manager)) : nullptr;
  }();
  return kBackend;
}

}  // namespace ddssec::cryptography
