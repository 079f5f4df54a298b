// Documents that are renewed while their participant runs.
#pragma once

#include <utility>

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {

/// The documents of one participant, in files that it looks at once a second.
class DocumentFiles {
 public:
  explicit DocumentFiles(const spi::PropertyList& documents) { put(documents); }
  void put(const spi::PropertyList& documents) {
    for (const auto& [name, file] : kFiles)
      folder_.replace(file, spi::find_property(documents, name)->substr(data_uri("").size()));
  }
  spi::PropertyList in(spi::PropertyList documents) const {
    for (auto& property : documents)
      for (const auto& [name, file] : kFiles)
        if (property.name == name) property.value = "file:" + folder_.path() + "/" + file;
    documents.push_back({std::string(spi::property::kFilesPollInterval), "1", false});
    return documents;
  }

 private:
  static constexpr std::pair<std::string_view, const char*> kFiles[] = {
      {spi::property::kIdentityCertificate, "cert.pem"},
      {spi::property::kPrivateKey, "key.pem"},
      {spi::property::kPermissions, "permissions.p7s"}};
  const test::TemporaryFolder folder_;
};

}  // namespace ddssec::rtps::testing
