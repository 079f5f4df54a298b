#include "plugins/spi/ocsp_policy.hpp"

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<OcspPolicy> ocsp_policy(const PropertyList& properties) {
  const auto* const text = find_property(properties, property::kOcsp);
  if (text == nullptr || *text == "soft") return OcspPolicy::soft;
  if (*text == "hard") return OcspPolicy::hard;
  if (*text == "ignore") return OcspPolicy::ignore;
  return fail(Code::invalid_property, {.document = std::string(property::kOcsp),
                                       .expected = "ignore, soft or hard",
                                       .found = text->substr(0, 64)});
}

}  // namespace ddssec::spi
