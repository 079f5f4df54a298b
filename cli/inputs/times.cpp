#include "cli/inputs/times.hpp"

#include <algorithm>
#include <charconv>

#include "governance/date_time.hpp"

namespace ddssec::cli {
namespace {

std::optional<std::chrono::seconds> duration_from(std::string_view text) {
  int number = 0;
  const auto* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || number < 0 || number > 100'000) return std::nullopt;
  const std::string_view unit(at, static_cast<std::size_t>(end - at));
  if (unit.empty() || unit == "d") return std::chrono::days(number);
  if (unit == "h") return std::chrono::hours(number);
  if (unit == "w") return std::chrono::weeks(number);
  return std::nullopt;
}

}  // namespace

std::string date(WallTime time) { return to_string(time).substr(0, 10); }

std::optional<WallTime> time_from(std::string_view text) {
  constexpr std::size_t kDate = std::string_view("2026-11-21").size();
  std::string whole(text);
  if (text.size() == kDate) whole += "T00:00:00Z";
  const auto time = governance::parse_date_time(whole, governance::Round::down);
  return time ? std::optional(time->time) : std::nullopt;
}

std::optional<WallTime> time_from(std::string_view text, WallTime now) {
  if (!text.starts_with('+') && !text.starts_with('-')) return time_from(text);
  const auto distance = duration_from(text.substr(1));
  if (!distance) return std::nullopt;
  const auto time = text.starts_with('+') ? now + *distance : now - *distance;
  return time < WallTime{} ? std::nullopt : std::optional(time);
}

Result<std::chrono::seconds> duration(const Arguments& arguments, std::string_view option) {
  const auto text = arguments.text(option);
  if (const auto out = duration_from(text)) return *out;
  return fail(Code::usage, {.field = std::string(option),
                            .expected = "a time such as 30d, 12h or 4w",
                            .found = '"' + text + '"'});
}

pki::Validity validity_of(int days, WallTime now) {
  return {now - kBackdated, now + std::chrono::days(days)};
}

Result<pki::Validity> validity(const Arguments& arguments, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto days, arguments.number("--days", 1, kMaxDays));
  return validity_of(days, now);
}

pki::Validity validity_after(const pki::Certificate& former, pki::Validity wanted, WallTime now) {
  if (former.not_before() <= now)
    wanted.not_before = std::max(wanted.not_before, former.not_before());
  return wanted;
}

}  // namespace ddssec::cli
