#include "plugins/spi/files_poll_interval.hpp"

#include <charconv>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {

Result<std::chrono::seconds> files_poll_interval(const PropertyList& properties) {
  const auto* const text = find_property(properties, property::kFilesPollInterval);
  if (text == nullptr) return kDefaultFilesPollInterval;
  std::uint32_t seconds = 0;
  const auto* const end = text->data() + text->size();
  const auto [stopped, error] = std::from_chars(text->data(), end, seconds);
  if (error == std::errc() && stopped == end && seconds <= kLongestFilesPollInterval.count())
    return std::chrono::seconds(seconds);
  return fail(Code::invalid_property,
              {.document = std::string(property::kFilesPollInterval),
               .expected = "seconds, at most " + std::to_string(kLongestFilesPollInterval.count()),
               .found = *text});
}

}  // namespace ddssec::spi
