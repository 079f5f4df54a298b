#include "programs/peer/session.hpp"

#include <csignal>
#include <cstdio>
#include <thread>

namespace ddssec::peer {
namespace {

volatile std::sig_atomic_t signalled = 0;

}  // namespace

void print_line(const char* event, Json fields) {
  Json line = {{"event", event}};
  line.update(fields);
  std::puts(line.dump(-1, ' ', false, Json::error_handler_t::replace).c_str());
  std::fflush(stdout);
}

bool is_interrupted() { return signalled != 0; }

void watch_signals() {
  for (int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { signalled = 1; });
}

Status Session::open() {
  end_ = nanoseconds() + static_cast<std::int64_t>(options_.timeout * 1e9);
  rtps::DomainParticipantOptions wanted{.domain_id = options_.domain,
                                        .entity_name = "ddssec-peer " + options_.role,
                                        .interfaces = options_.interfaces,
                                        .multicast = options_.interfaces != Options{}.interfaces,
                                        .announce_types = false};
  if (options_.security != "off") {
    DDSSEC_ASSIGN_OR_RETURN(auto security, runtime_.plugins().security_options(options_.security));
    wanted.security.emplace(std::move(security));
  }
  auto created = rtps::DomainParticipant::create(std::move(wanted), runtime_.services());
  if (!created) return std::unexpected(created.error());
  participant_ = std::move(*created);
  print_line("participant_created");
  return {};
}

rtps::Qos Session::writer_qos(bool keep_all) const {
  auto qos = rtps::default_writer_qos();
  qos.reliability.max_blocking_time = rtps::Duration{{1, 0}};
  if (keep_all) {
    qos.history.kind = rtps::HistoryKind::keep_all;
    qos.resource_limits.max_samples = 2048;
  } else {
    qos.history.depth = 64;
  }
  return qos;
}

rtps::Qos Session::reader_qos() const {
  auto qos = rtps::default_reader_qos();
  qos.reliability.kind = rtps::ReliabilityKind::reliable;
  qos.history.kind = rtps::HistoryKind::keep_all;
  return qos;
}

rtps::GroupQos Session::group_qos() const {
  rtps::GroupQos qos;
  if (!options_.partition.empty()) qos.partition = {options_.partition};
  return qos;
}

bool Session::is_over() const { return is_interrupted() || nanoseconds() >= end_; }

bool Session::wait_until(const std::function<bool()>& ready) const {
  while (!ready()) {
    if (is_over()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

void Session::note_authenticated() {
  const auto now = participant_->counters().authentication;
  for (; printed_.authenticated < now.authenticated; ++printed_.authenticated)
    print_line("auth", {{"ok", true}});
  for (; printed_.failed < now.failed; ++printed_.failed) print_line("auth", {{"ok", false}});
}

void Session::note_matched(const char* what, std::int32_t current) {
  note_authenticated();
  counts.ever_matched = counts.ever_matched || current > 0;
  if (current == last_printed_) return;
  last_printed_ = current;
  print_line("matched", {{"what", what}, {"current", current}});
}

int Session::finish(int code) {
  note_authenticated();
  print_line("done", {{"matched", counts.ever_matched},
                      {"written", counts.written},
                      {"received", counts.received},
                      {"corrupt", counts.corrupt},
                      {"auth_failed", printed_.failed}});
  print_line("exit", {{"code", code}});
  return code;
}

void Session::raise(const Event& event) {
  if (event.is_returned) return;  // print_refusal() prints that error
  if (options_.verbose || event.severity >= Severity::warning ||
      is_always_shown(event.error.code()))
    std::fprintf(stderr, "%s\n", event.to_line().c_str());
}

int print_refusal(const Error& error) {
  print_line("error", {{"what", error.to_sentence()}});
  print_line("exit", {{"code", int{kNotCreated}}});
  return kNotCreated;
}

}  // namespace ddssec::peer
