#include "cli/agent/hook_messages.hpp"

#include <algorithm>
#include <array>
#include <fcntl.h>
#include <unistd.h>

#include "base/text.hpp"

namespace ddssec::cli {
namespace {

constexpr std::size_t kMaxLine = 1024;

}  // namespace

HookMessages::HookMessages(HeldSignals& signals)
    : signals_(signals), output_(STDERR_FILENO, -1, std::chrono::seconds(1)) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return;
  own_end_ = FileDescriptor(ends[0]);
  hook_end_ = FileDescriptor(ends[1]);
  ::fcntl(own_end_.number(), F_SETFL, O_NONBLOCK);
  signals_.watch(own_end_.number(), [this] { return pass_on(); });
}

HookMessages::~HookMessages() {
  signals_.watch(-1, {});
  close_hook_end();
  if (own_end_) pass_on();
  if (!begun_.empty()) put_line(begun_);
}

void HookMessages::put_line(std::string_view line) {
  output_.put("hook: " + printable(line) + '\n');
}

// Reads one part only, because a hook may write without end. Returns false if the hook has closed
// its end.
bool HookMessages::pass_on() {
  std::array<char, 65536> part{};
  const auto size = ::read(own_end_.number(), part.data(), part.size());
  if (size > 0) begun_.append(part.data(), static_cast<std::size_t>(size));
  while (true) {
    const auto end = begun_.find('\n');
    if (end == begun_.npos && begun_.size() < kMaxLine) break;
    const auto length = std::min(end, kMaxLine);
    put_line(std::string_view(begun_).substr(0, length));
    begun_.erase(0, length == end ? length + 1 : length);
  }
  return size != 0;
}

}  // namespace ddssec::cli
