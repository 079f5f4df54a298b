#include <memory>

#include <intel-ipsec-mb.h>

#include "plugins/cryptography/aead_backends.hpp"

namespace ddssec::cryptography {
namespace {

static_assert(sizeof(gcm_key_data) <= kKeyStorage);

struct ManagerDeleter {
  void operator()(IMB_MGR* manager) const noexcept { free_mb_mgr(manager); }
};
using Manager = std::unique_ptr<IMB_MGR, ManagerDeleter>;

gcm_key_data* key_in(KeyStorage storage) {
  return static_cast<gcm_key_data*>(static_cast<void*>(storage));
}

/// The direct GCM calls: one function call a message, no state but the key, which they only read.
class IpsecMb final : public AeadBackend {
 public:
  explicit IpsecMb(Manager manager) : manager_(std::move(manager)) {}
  std::string_view name() const override { return "ipsec-mb"; }

 protected:
  bool expand(KeyStorage storage, BytesView key) const override {
    auto* const place = new (storage) gcm_key_data;
    (key.size() == 16 ? manager_->gcm128_pre : manager_->gcm256_pre)(key.data(), place);
    return true;
  }

  bool seal(KeyStorage storage, std::size_t key_size, const SealRequest& request) const override {
    gcm_context_data context;
    (key_size == 16 ? manager_->gcm128_enc : manager_->gcm256_enc)(
        key_in(storage), &context, request.out, request.plain.data(), request.plain.size(),
        request.iv.data(), request.aad.data(), request.aad.size(), request.tag.data(), kTagSize);
    return true;
  }

  bool open(KeyStorage storage, std::size_t key_size, const OpenRequest& request,
            TagView) const override {
    gcm_context_data context;
    (key_size == 16 ? manager_->gcm128_dec : manager_->gcm256_dec)(
        key_in(storage), &context, request.out, request.cipher.data(), request.cipher.size(),
        request.iv.data(), request.aad.data(), request.aad.size(), request.tag.data(), kTagSize);
    return true;
  }

  void destroy(KeyStorage) const noexcept override {}

 private:
  Manager manager_;
};

Manager usable_manager() {
  Manager manager(alloc_mb_mgr(0));
  if (!manager) return nullptr;
  IMB_ARCH architecture = IMB_ARCH_NONE;
  init_mb_mgr_auto(manager.get(), &architecture);
  // Without AES-NI the library emulates it, slower than OpenSSL.
  const bool aes_in_hardware =
      (manager->features & IMB_FEATURE_AESNI) != 0 && architecture != IMB_ARCH_NOAESNI;
  const bool broken = (manager->features & IMB_FEATURE_SELF_TEST) != 0 &&
                      (manager->features & IMB_FEATURE_SELF_TEST_PASS) == 0;
  if (imb_get_errno(manager.get()) != 0 || !aes_in_hardware || broken) return nullptr;
  return manager;
}

}  // namespace

const AeadBackend* ipsec_mb_backend() {
  static const auto kBackend = []() -> std::unique_ptr<const AeadBackend> {
    auto manager = usable_manager();
    if (!manager) return nullptr;
    return std::make_unique<IpsecMb>(std::move(manager));
  }();
  return kBackend.get();
}

}  // namespace ddssec::cryptography
