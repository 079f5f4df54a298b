#include "cli/agent/event_output.hpp"

#include <algorithm>
#include <cerrno>
#include <poll.h>
#include <string>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/report.hpp"

namespace ddssec::cli {
namespace {

using std::chrono::steady_clock;

// A pipe or socket that poll() reports has room for so much, so that write() does not block.
constexpr std::size_t kMaxPart = 4096;
constexpr std::chrono::seconds kTimeForErrors{1};

struct Written {
  std::size_t octets = 0;
  int error = 0;
};

// True if the file takes a part, or refuses it at once.
bool is_ready(int file, steady_clock::time_point deadline) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - steady_clock::now());
    pollfd one{file, POLLOUT, 0};
    const int ready = ::poll(&one, 1, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
    if (ready >= 0 || errno != EINTR) return ready > 0;
  }
}

Written write_within(int file, std::string_view text, std::chrono::milliseconds time) {
  const auto deadline = steady_clock::now() + time;
  Written out;
  while (out.octets < text.size()) {
    if (!is_ready(file, deadline)) return {out.octets, ETIMEDOUT};
    const auto part = text.substr(out.octets, kMaxPart);
    const auto size = ::write(file, part.data(), part.size());
    if (size < 0 && errno != EINTR && errno != EAGAIN) return {out.octets, errno};
    if (size > 0) out.octets += static_cast<std::size_t>(size);
  }
  return out;
}

void report_loss(int file, ErrorDetails details) {
  if (file < 0) return;
  details.document = "standard output";
  const Error error(tool_code::events_lost, std::move(details));
  write_within(file, diagnostics_text(report_of(error), {}), kTimeForErrors);
}

}  // namespace

void EventOutput::put(std::string_view line) {
  const auto text = (is_cut_ ? "\n" : "") + std::string(line);
  const auto written = write_within(output_, text, lost_ == 0 ? time_ : Milliseconds(0));
  if (written.octets == text.size()) {
    if (lost_ > 0) report_loss(errors_, {.found = fmt::format("{} lost", lost_)});
    is_cut_ = false;
    lost_ = 0;
    return;
  }
  if (written.octets > 0) is_cut_ = !is_cut_ || written.octets > 1;
  if (lost_++ > 0) return;
  const bool is_unread = written.error == ETIMEDOUT;
  report_loss(errors_, {.note = is_unread ? "nothing reads it" : errno_text(written.error)});
}

}  // namespace ddssec::cli
