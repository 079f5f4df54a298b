#include "rtps/dcps/caught_exceptions.hpp"

#include <bit>

#include <fmt/format.h>

namespace ddssec::rtps {

void CaughtExceptions::note(std::string_view what, const char* thrown) noexcept {
  const auto count = ++count_;
  if (!std::has_single_bit(count)) return;
  try {
    events_.raise(Event(Error(Code::rtps_exception,
                              {.document = std::string(what),
                               .expected = "no exception",
                               .found = fmt::format("{}; {} so far", thrown, count),
                               .note = "another event follows when they are twice as many"})));
  } catch (...) {
    // If there is no memory for the event, the exception is still counted.
  }
}

}  // namespace ddssec::rtps
