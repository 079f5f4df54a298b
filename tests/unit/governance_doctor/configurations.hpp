// Configurations of Cyclone DDS, each with a change.
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace ddssec::governance::doctor::configurations {

inline constexpr const char* kAuthentication =
    "<Authentication><Library path=\"dds_security_auth\" initFunction=\"init_authentication\" "
    "finalizeFunction=\"finalize_authentication\"/><IdentityCA>file:/a/ca</IdentityCA>"
    "<IdentityCertificate>file:/a/cert</IdentityCertificate><PrivateKey>file:/a/key</PrivateKey>"
    "</Authentication>";

inline constexpr const char* kAccessControl =
    "<AccessControl><PermissionsCA>file:/a/pca</PermissionsCA><Governance>file:/a/g</Governance>"
    "<Permissions>file:/a/p</Permissions></AccessControl>";

inline std::string security() {
  return std::string("<Security>") + kAuthentication + "<Cryptographic/>" + kAccessControl +
         "</Security>";
}

inline std::string domain(const std::string& inside, const std::string& attributes = "") {
  return "<Domain" + attributes + ">" + inside + "</Domain>";
}

inline std::string document(const std::string& inside) {
  return "<CycloneDDS>" + inside + "</CycloneDDS>";
}

inline std::string replaced(const std::string& from, const std::string& to) {
  auto text = document(domain(security()));
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace ddssec::governance::doctor::configurations
