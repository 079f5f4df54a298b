#include "plugins/cyclonedds/cryptography_adapter.hpp"

#include <mutex>
#include <set>

namespace ddssec::cyclonedds {
namespace {

struct Adapters {
  std::mutex mutex;
  std::set<CryptographyAdapter*> all;
};
Adapters& adapters() {
  // The object is never destroyed, because authentication's timer may ask at exit.
  static auto& of_process = *new Adapters;
  return of_process;
}

}  // namespace

CryptographyAdapter::CryptographyAdapter(std::unique_ptr<Host> host,
                                         const MakePlugin<spi::Cryptography>& make,
                                         ddsi_domaingv* domain)
    : dds_security_cryptography{},
      host_(std::move(host)),
      plugin_(make(host_->services())),
      key_factory_(plugin_->key_factory()),
      key_exchange_(plugin_->key_exchange()),
      transform_(plugin_->transform()),
      transform_table_(kTransformFunctions, this),
      key_factory_table_(kKeyFactoryFunctions, this),
      key_exchange_table_(kKeyExchangeFunctions, this),
      reader_ends_([this] { return find_host_entities(host_->code()); }) {
  gv = domain;
  crypto_transform = &transform_table_;
  crypto_key_factory = &key_factory_table_;
  crypto_key_exchange = &key_exchange_table_;
  const std::lock_guard lock(adapters().mutex);
  adapters().all.insert(this);
}

CryptographyAdapter::~CryptographyAdapter() {
  {
    const std::lock_guard lock(adapters().mutex);
    adapters().all.erase(this);
  }
  reader_ends_.stop();  // this thread calls the host
}

void CryptographyAdapter::note_local(spi::ParticipantCryptoHandle local,
                                     spi::IdentityHandle identity) {
  const std::lock_guard lock(locals_mutex_);
  locals_[local] = identity;
}

void CryptographyAdapter::forget_local(spi::ParticipantCryptoHandle local) {
  const std::lock_guard lock(locals_mutex_);
  locals_.erase(local);
}

void CryptographyAdapter::cut_off(spi::IdentityHandle identity) {
  const std::lock_guard lock(adapters().mutex);
  for (auto* const adapter : adapters().all) {
    const std::lock_guard locals_lock(adapter->locals_mutex_);
    for (const auto& [local, its_identity] : adapter->locals_)
      if (its_identity == identity) adapter->key_factory().cut_off(local);
  }
}

void CryptographyAdapter::look_for_ended_readers() noexcept {
  const std::lock_guard lock(adapters().mutex);
  for (auto* const adapter : adapters().all) adapter->reader_ends_.poll_soon();
}

bool CryptographyAdapter::poll_stranded_keys(spi::IdentityHandle remote) {
  const std::lock_guard lock(adapters().mutex);
  bool are_stranded = false;
  for (auto* const adapter : adapters().all)
    are_stranded |= adapter->key_factory().poll_stranded_keys(remote);
  return are_stranded;
}

}  // namespace ddssec::cyclonedds
