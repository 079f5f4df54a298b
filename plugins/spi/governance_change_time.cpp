#include "plugins/spi/governance_change_time.hpp"

#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<std::chrono::seconds> governance_change_time(const PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto seconds,
      number_property(properties, property::kGovernanceChangeTime,
                      {.unit = "seconds", .max = kMaxGovernanceChangeTime.count()},
                      kDefaultGovernanceChangeTime.count()));
  return std::chrono::seconds(seconds);
}

}  // namespace ddssec::spi
