#include "plugins/spi/number_property.hpp"

#include <charconv>

namespace ddssec::spi {
namespace {

std::string in_words(const NumberRange& range) {
  return std::string(range.unit) + " from " + std::to_string(range.min) + " to " +
         std::to_string(range.max) + ", or 0";
}

}  // namespace

Result<std::uint64_t> number_property(const PropertyList& properties, std::string_view name,
                                      const NumberRange& range, std::uint64_t otherwise) {
  const auto* const text = find_property(properties, name);
  if (text == nullptr) return otherwise;
  std::uint64_t number = 0;
  const auto* const end = text->data() + text->size();
  const auto [stopped, error] = std::from_chars(text->data(), end, number);
  const bool is_one = error == std::errc() && stopped == end;
  if (is_one && (number == 0 || (number >= range.min && number <= range.max))) return number;
  return fail(
      Code::invalid_property,
      {.document = std::string(name), .expected = in_words(range), .found = text->substr(0, 64)});
}

}  // namespace ddssec::spi
