#include "plugins/spi/key_limits.hpp"

#include <limits>

#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<KeyLimits> key_limits(const PropertyList& properties) {
  constexpr NumberRange kLifetime{"seconds", kMinKeyLifetime.count(), kMaxKeyLifetime.count()};
  constexpr NumberRange kBlocks{"blocks of 16 octets", 1,
                                std::numeric_limits<std::uint64_t>::max()};
  DDSSEC_ASSIGN_OR_RETURN(const auto lifetime,
                          number_property(properties, property::kKeyLifetime, kLifetime, 0));
  DDSSEC_ASSIGN_OR_RETURN(const auto blocks,
                          number_property(properties, property::kMaxBlocksPerKey, kBlocks, 0));
  return KeyLimits{std::chrono::seconds(lifetime), blocks};
}

}  // namespace ddssec::spi
