// Standard output of the agent, whose reader may stop.
#pragma once

#include <chrono>
#include <cstddef>
#include <string_view>
#include <unistd.h>

namespace ddssec::cli {

/// Writes lines to a file in bounded time, because the agent must renew certificates and obey
/// SIGTERM also if the reader of its events stops, has ended, or has no room. Lines that cannot be
/// written are lost. The loss is reported to another file, once at its begin and once at its end
/// (events_lost). A line that was cut ends with a line break before the next one.
class EventOutput {
 public:
  using Milliseconds = std::chrono::milliseconds;
  /// `errors` is -1 if a loss is not reported. `time` is how long one line may take. After a loss
  /// no time is given until a line is written.
  explicit EventOutput(int output = STDOUT_FILENO, int errors = STDERR_FILENO,
                       Milliseconds time = std::chrono::seconds(5))
      : output_(output), errors_(errors), time_(time) {}

  /// Writes a line, with its line break. SIGPIPE must be ignored.
  void put(std::string_view line);

 private:
  int output_, errors_;
  Milliseconds time_;
  std::size_t lost_ = 0;  ///< lines that were lost since the last one that was written
  bool is_cut_ = false;   ///< true if only a part of the last line was written
};

}  // namespace ddssec::cli
