#include "cli/frame/progress.hpp"

#include <cstdio>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

namespace ddssec::cli {
namespace {

using namespace std::chrono_literals;

bool is_silent = false;

}  // namespace

void hide_progress() { is_silent = true; }

Progress::Progress(std::string what, std::size_t total)
    : what_(std::move(what)),
      total_(total),
      is_terminal_(::isatty(STDERR_FILENO) == 1),
      next_(std::chrono::steady_clock::now() + 1s) {}

Progress::~Progress() {
  if (has_begun_ && is_terminal_) std::fputs("\r\033[K", stderr);
}

void Progress::step() {
  ++done_;
  if (is_silent || std::chrono::steady_clock::now() < next_) return;
  next_ = std::chrono::steady_clock::now() + (is_terminal_ ? 200ms : 2000ms);
  has_begun_ = true;
  const auto line = fmt::format("{} of {} {}", done_, total_, what_);
  std::fputs((is_terminal_ ? '\r' + line : line + '\n').c_str(), stderr);
  std::fflush(stderr);
}

}  // namespace ddssec::cli
