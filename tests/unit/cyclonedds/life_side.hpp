// One of the two participants whose life whole_life.hpp plays.
#pragma once

#include <array>
#include <string>
#include <utility>

#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {

inline const std::string kPki = DDSSEC_DRIVER_PKI;
inline const std::string kOurs = DDSSEC_PLUGIN_DIR "/libddssec_";
inline const Paths kPaths = {kOurs + "authentication.so", kOurs + "access_control.so",
                             kOurs + "cryptography.so"};

/// The properties of a participant, in the form in which the host passes them.
struct Properties {
  explicit Properties(const std::string& name)
      : texts{{{"dds.sec.auth.identity_ca", "file:" + kPki + "/idca.pem"},
               {"dds.sec.auth.identity_certificate", "file:" + kPki + "/" + name + ".pem"},
               {"dds.sec.auth.private_key", "file:" + kPki + "/" + name + ".key"},
               {"dds.sec.access.permissions_ca", "file:" + kPki + "/permca.pem"},
               {"dds.sec.access.governance", "file:" + kPki + "/governance_origin.p7s"},
               {"dds.sec.access.permissions", "file:" + kPki + "/permissions_" + name + ".p7s"}}} {
    for (std::size_t i = 0; i < texts.size(); ++i)
      list[i] = {texts[i].first.data(), texts[i].second.data(), 0};
    qos.property.value = {6, 6, list.data()};
  }
  std::array<std::pair<std::string, std::string>, 6> texts;
  std::array<DDS_Security_Property_t, 6> list{};
  DDS_Security_Qos qos{};
};

/// Frees what a token holds, so that it can be made again.
inline void clear(DDS_Security_DataHolder& token) {
  Token dying;
  static_cast<DDS_Security_DataHolder&>(dying) = token;
  token = {};
}

/// One participant, and what it holds of its peer.
struct Side {
  explicit Side(const char* participant_name) : name(participant_name), properties(name) {}

  dds_security_authentication* auth() { return &domain.authentication(); }
  dds_security_access_control* access() { return &domain.access_control(); }
  dds_security_crypto_key_factory* factory() { return domain.cryptography().crypto_key_factory; }
  dds_security_crypto_transform* transform() { return domain.cryptography().crypto_transform; }
  dds_security_crypto_key_exchange* exchange() { return domain.cryptography().crypto_key_exchange; }

  std::string name;
  Properties properties;
  Domain domain{kPaths};
  DDS_Security_GUID_t guid{};
  Octets data;
  DDS_Security_IdentityHandle identity = 0;
  DDS_Security_PermissionsHandle permissions = 0;
  DDS_Security_ParticipantCryptoHandle crypto = 0;
  Token identity_token, permissions_token;
  DDS_Security_ParticipantSecurityAttributes attributes{};
  DDS_Security_EndpointSecurityAttributes endpoint_attributes{};
  std::int64_t endpoint = 0;
  DDS_Security_ValidationResult_t role = DDS_SECURITY_VALIDATION_FAILED;
  Peer peer;
  std::int64_t remote_endpoint = 0;
};

}  // namespace ddssec::driver
