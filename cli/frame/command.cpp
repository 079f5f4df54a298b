#include "cli/frame/command.hpp"

#include <charconv>

#include <fmt/format.h>

namespace ddssec::cli {

std::string Arguments::text(std::string_view name) const {
  const auto& values = all(name);
  return values.empty() ? std::string() : values.back();
}

const std::vector<std::string>& Arguments::all(std::string_view name) const {
  static const std::vector<std::string> kNone;
  const auto found = values_.find(name);
  return found == values_.end() ? kNone : found->second;
}

Result<int> Arguments::number(std::string_view name, int lowest, int highest) const {
  const auto value = text(name);
  int number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || number < lowest ||
      number > highest)
    return fail(Code::usage, {.field = std::string(name),
                              .expected = fmt::format("a number from {} to {}", lowest, highest),
                              .found = '"' + value + '"'});
  return number;
}

std::string Option::spellings() const {
  return letter.empty() ? std::string(name) : fmt::format("{},{}", letter, name);
}

std::string Command::full_name() const {
  return group.empty() ? std::string(name) : fmt::format("{} {}", group, name);
}

}  // namespace ddssec::cli
