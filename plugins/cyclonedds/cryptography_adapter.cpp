#include "plugins/cyclonedds/cryptography_adapter.hpp"

namespace ddssec::cyclonedds {

CryptographyAdapter::CryptographyAdapter(std::unique_ptr<Host> host,
                                         const MakeEngine<spi::Cryptography>& make,
                                         ddsi_domaingv* domain)
    : dds_security_cryptography{},
      host_(std::move(host)),
      engine_(make(host_->environment())),
      key_factory_engine_(engine_->key_factory()),
      key_exchange_engine_(engine_->key_exchange()),
      transform_engine_(engine_->transform()),
      transform_table_(kTransformFunctions, this),
      key_factory_table_(kKeyFactoryFunctions, this),
      key_exchange_table_(kKeyExchangeFunctions, this) {
  gv = domain;
  crypto_transform = &transform_table_;
  crypto_key_factory = &key_factory_table_;
  crypto_key_exchange = &key_exchange_table_;
}

}  // namespace ddssec::cyclonedds
