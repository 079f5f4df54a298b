// Properties with passphrases in them.
#pragma once

#include "plugins/spi/property_names.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {

namespace property = spi::property;

inline PropertyList passphrase(std::string_view text, std::string_view extra = {},
                               std::string_view cipher = {}) {
  PropertyList out = {{std::string(property::kPskPassphrase), "data:," + std::string(text)}};
  if (!extra.empty())
    out.push_back({std::string(property::kPskExtraPassphrases), "data:," + std::string(extra)});
  if (!cipher.empty()) out.push_back({std::string(property::kPskCipher), std::string(cipher)});
  return out;
}

}  // namespace ddssec::cryptography::testing
