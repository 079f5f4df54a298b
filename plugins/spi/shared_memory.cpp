#include "plugins/spi/shared_memory.hpp"

#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/number_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<SharedMemory> shared_memory(const PropertyList& properties) {
  SharedMemory out;
  if (const auto* const text = find_property(properties, property::kSharedMemory)) {
    out.is_on = *text == "on";
    if (!out.is_on && *text != "off")
      return fail(Code::invalid_property, {.document = std::string(property::kSharedMemory),
                                           .expected = "on or off",
                                           .found = text->substr(0, 64)});
  }
  DDSSEC_ASSIGN_OR_RETURN(out.trusts_kernel, flag_property(properties, property::kTrustKernel));
  DDSSEC_ASSIGN_OR_RETURN(out.with_other_users,
                          flag_property(properties, property::kSharedWithOtherUsers));
  constexpr auto kMax = std::uint64_t{1} << 40;
  DDSSEC_ASSIGN_OR_RETURN(const auto most,
                          number_property(properties, property::kMaxSharedOctets,
                                          {.unit = "octets", .max = kMax}, out.max_octets));
  out.max_octets = most;
  return out;
}

}  // namespace ddssec::spi
