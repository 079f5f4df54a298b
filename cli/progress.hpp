// Shows how far a long command is.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace ddssec::cli {

/// From here on commands say nothing of their progress (-q).
void say_no_progress();

/// Counts steps and says so on standard error, but not before a second has passed. On a terminal
/// one line changes in place; elsewhere a new line comes now and then.
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
  bool said_ = false;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace ddssec::cli
