#include "governance/date_time.hpp"

#include <limits>

namespace ddssec::governance {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

// A cursor over the text; after one failed step, all further steps fail.
class Cursor {
 public:
  explicit Cursor(std::string_view text) : text_(text) {}

  int digits(std::size_t count) {
    int value = 0;
    for (std::size_t i = 0; i < count; ++i) value = value * 10 + digit();
    return value;
  }
  void expect(char c) {
    if (!accept(c)) good_ = false;
  }
  bool accept(char c) {
    if (text_.empty() || text_.front() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  bool next_is_digit() const {
    return !text_.empty() && text_.front() >= '0' && text_.front() <= '9';
  }
  bool good_at_end() const { return good_ && text_.empty(); }
  bool good() const { return good_; }

 private:
  int digit() {
    if (!next_is_digit()) {
      good_ = false;
      return 0;
    }
    const int value = text_.front() - '0';
    text_.remove_prefix(1);
    return value;
  }

  std::string_view text_;
  bool good_ = true;
};

std::optional<std::chrono::sys_days> read_day(Cursor& in) {
  const int year = in.digits(4);
  in.expect('-');
  const auto month = static_cast<unsigned>(in.digits(2));
  in.expect('-');
  const auto day = static_cast<unsigned>(in.digits(2));
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(month),
                                         std::chrono::day(day)};
  if (!in.good() || year < 1970 || !date.ok()) return std::nullopt;
  return std::chrono::sys_days(date);
}

std::optional<seconds> read_time_of_day(Cursor& in) {
  const int h = in.digits(2);
  in.expect(':');
  const int m = in.digits(2);
  in.expect(':');
  const int s = in.digits(2);
  const bool midnight = h == 24 && m == 0 && s == 0;
  if (!in.good() || (h > 23 && !midnight) || m > 59 || s > 59) return std::nullopt;
  return hours(h) + minutes(m) + seconds(s);
}

// True if there are digits other than 0 after the point; empty if the form is wrong.
std::optional<bool> read_fraction(Cursor& in) {
  if (!in.accept('.')) return false;
  if (!in.next_is_digit()) return std::nullopt;
  bool above_zero = false;
  while (in.next_is_digit()) above_zero |= in.digits(1) != 0;
  return above_zero;
}

// The last time that a signed 64-bit count of nanoseconds can represent.
constexpr WallTime kEndOfNanoseconds{
    seconds(std::numeric_limits<std::int64_t>::max() / 1'000'000'000)};

struct Zone {
  bool given;
  minutes east;
};

std::optional<Zone> read_zone(Cursor& in) {
  if (in.accept('Z')) return Zone{true, minutes(0)};
  const bool east = in.accept('+');
  if (!east && !in.accept('-')) return Zone{false, minutes(0)};
  const int h = in.digits(2);
  in.expect(':');
  const int m = in.digits(2);
  // XML Schema 1.0, 3.2.7.3: up to 14 hours.
  if (!in.good() || m > 59 || h > 14 || (h == 14 && m != 0)) return std::nullopt;
  const auto offset = hours(h) + minutes(m);
  return Zone{true, east ? offset : -offset};
}

}  // namespace

std::optional<DateTime> parse_date_time(std::string_view text, Round round) {
  Cursor in(text);
  const auto day = read_day(in);
  in.expect('T');
  if (!day || !in.good()) return std::nullopt;
  const auto time_of_day = read_time_of_day(in);
  if (!time_of_day) return std::nullopt;
  const auto fraction = read_fraction(in);
  if (!fraction || (*fraction && *time_of_day == hours(24))) return std::nullopt;
  const auto zone = read_zone(in);
  if (!zone || !in.good_at_end()) return std::nullopt;
  WallTime time = *day + *time_of_day - zone->east;
  if (*fraction && round == Round::up) time += seconds(1);
  const bool is_read_alike_by_cyclonedds =
      *time_of_day != hours(24) && std::chrono::abs(zone->east) <= hours(12) &&
      time + zone->east < kEndOfNanoseconds && time < kEndOfNanoseconds;
  return DateTime{.time = time,
                  .has_zone = zone->given,
                  .east = zone->east,
                  .has_fraction = *fraction,
                  .is_read_alike_by_cyclonedds = is_read_alike_by_cyclonedds};
}

}  // namespace ddssec::governance
