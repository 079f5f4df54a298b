#include "plugins/spi/busy_wait.hpp"

#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<std::optional<std::chrono::microseconds>> busy_wait(const PropertyList& properties) {
  std::optional<std::chrono::microseconds> out;
  if (find_property(properties, property::kBusyWait) == nullptr) return out;
  constexpr auto kMax = static_cast<std::uint64_t>(kMaxBusyWait.count());
  DDSSEC_ASSIGN_OR_RETURN(
      const auto count,
      number_property(properties, property::kBusyWait, {.unit = "microseconds", .max = kMax}, 0));
  return out.emplace(count);
}

}  // namespace ddssec::spi
