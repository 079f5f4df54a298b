#include "plugins/spi/files_poll_interval.hpp"

#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<std::chrono::seconds> files_poll_interval(const PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto seconds,
                          number_property(properties, property::kFilesPollInterval,
                                          {.unit = "seconds", .max = kMaxFilesPollInterval.count()},
                                          kDefaultFilesPollInterval.count()));
  return std::chrono::seconds(seconds);
}

}  // namespace ddssec::spi
