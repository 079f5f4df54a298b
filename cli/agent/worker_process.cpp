#include "cli/agent/worker_process.hpp"

#include <string>

#include "cli/agent/agent_messages.hpp"

namespace ddssec::cli {

using End = ChildProcess::End;

Deadline WorkerProcess::deadline() const {
  const auto time = owner_ ? slow_.time_for(*owner_, clock_.since_boot()) : SlowOwners::kTime;
  return std::chrono::steady_clock::now() + time;
}

void WorkerProcess::note_slow() {
  if (owner_) slow_.note(*owner_, clock_.since_boot());
}

std::unexpected<Error> WorkerProcess::ended_error(End end) {
  if (end == End::too_slow) note_slow();
  return no_answer_error(end);
}

Status WorkerProcess::write(std::string_view line) {
  const auto end = process_.write(line, deadline());
  return end == End::done ? Status() : ended_error(end);
}

Result<Json> WorkerProcess::read() {
  std::string line;
  const auto end = process_.read_line(line, kMaxAgentLine, deadline());
  return end == End::done ? json_from(line) : ended_error(end);
}

std::optional<ChildProcess> WorkerProcess::end() {
  if (process_.stop()) return std::nullopt;
  note_slow();
  return std::move(process_);
}

}  // namespace ddssec::cli
