#include "programs/shapes/session.hpp"

#include <algorithm>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <filesystem>

namespace ddssec::shapes {
namespace {

sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

rtps::Duration duration_of(std::int64_t milliseconds) {
  return rtps::Duration::from(std::chrono::milliseconds(milliseconds));
}

// Digits in brackets are the size of a sample; no other output may look like that.
void print_status(const char* what, const rtps::Topic& topic, const std::string& rest) {
  print_line("%s() topic: '%s'  type: '%s' : %s", what, topic.name().c_str(),
             topic.type_name().c_str(), rest.c_str());
}

void print_matched(const char* what, const char* peers, const rtps::Topic& topic,
                   const rtps::MatchedStatus& status) {
  print_status(what, topic,
               std::string("matched ") + peers + " " + std::to_string(status.current_count) +
                   " (change = " + std::to_string(status.current_count_change) + ")");
}

void print_incompatible(const char* what, const rtps::Topic& topic,
                        const rtps::IncompatibleQosStatus& status) {
  print_status(what, topic,
               std::to_string(static_cast<int>(status.last_policy_id)) + " (" + status.last.policy +
                   ": offered " + status.last.offered + ", requested " + status.last.requested +
                   ")");
}

void print_count(const char* what, const rtps::Topic& topic, const rtps::CountStatus& status) {
  print_status(what, topic,
               "(total = " + std::to_string(status.total_count) +
                   ", change = " + std::to_string(status.total_count_change) + ")");
}

}  // namespace

void print_line(const char* format, ...) {
  std::array<char, 2048> line;
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(line.data(), line.size(), format, values);
  va_end(values);
  std::puts(line.data());
  std::fflush(stdout);
}

void hold_signals() {
  std::signal(SIGXFSZ, SIG_IGN);  // a file size limit is treated like a full disk
  const auto set = ending_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

void StatusLines::on_publication_matched(rtps::AnyDataWriter& writer,
                                         const rtps::MatchedStatus& status) {
  print_matched("on_publication_matched", "readers", writer.topic(), status);
}
void StatusLines::on_offered_incompatible_qos(rtps::AnyDataWriter& writer,
                                              const rtps::IncompatibleQosStatus& status) {
  print_incompatible("on_offered_incompatible_qos", writer.topic(), status);
}
void StatusLines::on_offered_deadline_missed(rtps::AnyDataWriter& writer,
                                             const rtps::DeadlineMissedStatus& status) {
  print_count("on_offered_deadline_missed", writer.topic(), status);
}
void StatusLines::on_liveliness_lost(rtps::AnyDataWriter& writer,
                                     const rtps::LivelinessLostStatus& status) {
  print_count("on_liveliness_lost", writer.topic(), status);
}
void StatusLines::on_subscription_matched(rtps::AnyDataReader& reader,
                                          const rtps::MatchedStatus& status) {
  print_matched("on_subscription_matched", "writers", reader.topic(), status);
}
void StatusLines::on_requested_incompatible_qos(rtps::AnyDataReader& reader,
                                                const rtps::IncompatibleQosStatus& status) {
  print_incompatible("on_requested_incompatible_qos", reader.topic(), status);
}
void StatusLines::on_requested_deadline_missed(rtps::AnyDataReader& reader,
                                               const rtps::DeadlineMissedStatus& status) {
  print_count("on_requested_deadline_missed", reader.topic(), status);
}
void StatusLines::on_liveliness_changed(rtps::AnyDataReader& reader,
                                        const rtps::LivelinessChangedStatus& status) {
  print_status("on_liveliness_changed", reader.topic(),
               "(alive = " + std::to_string(status.alive_count) +
                   ", not_alive = " + std::to_string(status.not_alive_count) + ")");
}
void StatusLines::on_inconsistent_topic(rtps::Topic& topic,
                                        const rtps::InconsistentTopicStatus& status) {
  print_count("on_inconsistent_topic", topic, status);
}

Status Session::open() {
  rtps::DomainParticipantOptions wanted{.domain_id = options_.domain,
                                        .entity_name = "ddssec-shapes",
                                        .interfaces = options_.interfaces};
  DDSSEC_ASSIGN_OR_RETURN(wanted.durability_store, store());
  if (options_.security != "off") {
    DDSSEC_ASSIGN_OR_RETURN(auto security, runtime_.plugins().security_options(options_.security));
    wanted.security.emplace(std::move(security));
  }
  if (options_.announcement_period)
    wanted.announcement_period = std::chrono::milliseconds(*options_.announcement_period);
  if (options_.fragment_size) wanted.fragment_size = *options_.fragment_size;
  DDSSEC_ASSIGN_OR_RETURN(participant_,
                          rtps::DomainParticipant::create(std::move(wanted), runtime_.services()));
  participant_->set_listener(&lines_);
  return {};
}

// Only one process can use a store, so each topic and colour has its own.
Result<std::string> Session::store() const {
  if (!options_.publish || options_.durability != rtps::DurabilityKind::persistent ||
      options_.durability_directory.empty())
    return std::string();
  auto name = options_.topic + "-" + options_.color;
  std::ranges::replace(name, '/', '_');
  const std::filesystem::path directory(options_.durability_directory);
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error)
    return fail(Code::rtps_store_unusable, {.document = directory,
                                            .expected = "a directory that can be written",
                                            .found = error.message()});
  return (directory / ("shapes-" + std::to_string(options_.domain) + "-" + name)).string();
}

Session::~Session() {
  if (participant_) participant_->set_listener(nullptr);
}

std::optional<rtps::FilterText> Session::filter() const {
  if (!options_.filter.empty()) return rtps::FilterText{options_.filter, {}};
  if (!options_.color.empty()) return rtps::FilterText{"color = %0", {"'" + options_.color + "'"}};
  return std::nullopt;
}

rtps::GroupQos Session::group_qos() const {
  rtps::GroupQos qos;
  qos.presentation = options_.presentation;
  if (!options_.partition.empty()) qos.partition = {options_.partition};
  return qos;
}

rtps::Qos Session::common_qos() const {
  rtps::Qos qos;
  qos.reliability.kind =
      options_.reliable ? rtps::ReliabilityKind::reliable : rtps::ReliabilityKind::best_effort;
  qos.durability = options_.durability;
  qos.data_representation = {options_.representation};
  if (options_.history_depth == 0) {
    qos.history.kind = rtps::HistoryKind::keep_all;
  } else if (options_.history_depth) {
    qos.history.depth = *options_.history_depth;
  }
  qos.durability_service.history = qos.history;
  if (options_.deadline.value_or(0) > 0) qos.deadline = duration_of(*options_.deadline);
  if (options_.ownership_strength >= 0) qos.ownership = rtps::OwnershipKind::exclusive;
  return qos;
}

rtps::Qos Session::writer_qos() const {
  auto qos = common_qos();
  if (options_.ownership_strength >= 0) qos.ownership_strength = options_.ownership_strength;
  if (options_.lifespan > 0) qos.lifespan = duration_of(options_.lifespan);
  qos.autodispose_unregistered_instances = false;  // as in the OMG's shapes demo
  return qos;
}

rtps::Qos Session::reader_qos() const {
  auto qos = common_qos();
  if (options_.time_filter > 0) qos.time_based_filter = duration_of(options_.time_filter);
  return qos;
}

bool Session::pause(std::int64_t milliseconds) {
  const auto set = ending_signals();
  const timespec most{milliseconds / 1000, milliseconds % 1000 * 1000000};
  return sigtimedwait(&set, nullptr, &most) < 0;
}

void Session::raise(const Event& event) {
  if (options_.verbose && !event.is_returned)  // not_created() prints that error
    std::fprintf(stderr, "%s\n", event.to_line().c_str());
}

int not_created(const char* what, const Error& error) {
  print_line("failed to create %s", what);
  std::fprintf(stderr, "ddssec-shapes: %s\n", error.to_sentence().c_str());
  return kNotInitialised;
}

}  // namespace ddssec::shapes
