// Shows the progress of a long command.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace ddssec::cli {

/// From now on commands show no progress (-q).
void hide_progress();

/// Counts steps and shows them on standard error, beginning after one second. On a terminal one
/// line is updated in place; elsewhere a new line is written from time to time.
class Progress {
 public:
  Progress(std::string what, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void step();

 private:
  std::string what_;
  std::size_t total_;
  std::size_t done_ = 0;
  bool is_terminal_;
  bool has_begun_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace ddssec::cli
