#include "plugins/spi/end_warning.hpp"

#include <algorithm>
#include <charconv>
#include <functional>
#include <ranges>
#include <utility>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

using std::chrono::days;

constexpr std::size_t kMaxWarnings = 8;
constexpr int kMaxDays = 3650;

std::optional<int> number(std::string_view text) {
  int value = 0;
  const auto* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end || value < 1 || value > kMaxDays) return std::nullopt;
  return value;
}

std::optional<WarningDays> parse(std::string_view text) {
  if (text == "0") return WarningDays{};
  if (text.empty()) return std::nullopt;
  WarningDays out;
  for (const auto part : std::views::split(text, ',')) {
    const auto value = number(std::string_view(part.begin(), part.end()));
    if (!value || out.size() == kMaxWarnings) return std::nullopt;
    out.emplace_back(*value);
  }
  std::ranges::sort(out, std::greater());
  return out;
}

}  // namespace

Result<WarningDays> warning_days(const PropertyList& properties) {
  const auto* const text = find_property(properties, property::kWarnBeforeEnd);
  if (text == nullptr) return WarningDays{days(30), days(7), days(1)};
  if (auto parsed = parse(*text)) return *std::move(parsed);
  return fail(Code::invalid_property,
              {.document = std::string(property::kWarnBeforeEnd),
               .expected = "up to 8 numbers of days from 1 to 3650 with commas between them, or 0",
               .found = text->substr(0, 64)});
}

bool EndWarning::is_due(WallTime begin, WallTime end, WallTime now) {
  if (end_ != end) last_day_.reset();
  end_ = end;
  if (now >= end || days_.empty()) return false;
  if (days_.back() > (end - begin) / 3)
    return end - now <= (end - begin) / 6 && !std::exchange(last_day_, days(0));
  const auto late = std::ranges::find_if(days_ | std::views::reverse, [&](days before) {
    return end - now <= before && before <= (end - begin) / 3;
  });
  if (late == days_.rend() || (last_day_ && *last_day_ <= *late)) return false;
  last_day_ = *late;
  return true;
}

}  // namespace ddssec::spi
