// A cryptography adapter over a mocked plugin.
#pragma once

#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds::cryptography_adapters {

struct CryptographyAdapterTest : testing::Test {
  Harness<CryptographyAdapter, MockCryptography, spi::Cryptography> harness;
  dds_security_crypto_key_factory* factory = harness.adapter.crypto_key_factory;
  dds_security_crypto_key_exchange* exchange = harness.adapter.crypto_key_exchange;
  dds_security_crypto_transform* transform = harness.adapter.crypto_transform;
  MockCryptography& plugin = *harness.plugin;
  Refusal refusal;

  Bytes secret_octets = Bytes(32, 9);
  SharedSecretLayout secret{secret_octets.data(), 32, {1}, {2}};
  DDS_Security_SharedSecretHandle secret_handle =
      reinterpret_cast<DDS_Security_SharedSecretHandle>(&secret);
  DDS_Security_ParticipantSecurityAttributes participant{};
  DDS_Security_EndpointSecurityAttributes endpoint{};
};

}  // namespace ddssec::cyclonedds::cryptography_adapters
