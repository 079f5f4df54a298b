// The participant, the clock, JSON lines and termination, which all roles of ddssec-peer share.
#pragma once

#include <functional>
#include <memory>
#include <peer_types.hpp>

#include <nlohmann/json.hpp>

#include "programs/peer/options.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "secured/runtime.hpp"

namespace ddssec::peer {

using Json = nlohmann::ordered_json;

/// Prints one line on standard output and flushes it: {"event": name, fields...}.
void print_line(const char* event, Json fields = Json::object());

/// True if SIGTERM or SIGINT arrived.
bool is_interrupted();
void watch_signals();

/// The counts in the `done` line.
struct Counts {
  std::uint64_t written = 0, received = 0, corrupt = 0;
  bool ever_matched = false;
};

/// The participant of one run of the program.
class Session final : private EventSink {
 public:
  explicit Session(const Options& options) : options_(options) {}

  /// Creates the participant. Errors: those of SecurityPluginSet::security_options and
  /// DomainParticipant::create.
  Status open();
  const Options& options() const { return options_; }
  rtps::DomainParticipant& participant() { return *participant_; }
  std::string topic_or(const char* own) const {
    return options_.topic.empty() ? own : options_.topic;
  }
  /// Creates a writer or a reader on the topic, in the partition of the options. The participant
  /// owns it.
  template <class T>
  Result<rtps::DataWriter<T>*> writer(const std::string& topic, bool keep_all) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return participant_->create_publisher(group_qos())
        .create_datawriter<T>(**on, writer_qos(keep_all));
  }
  template <class T>
  Result<rtps::DataReader<T>*> reader(const std::string& topic,
                                      rtps::DataReaderListener* listener = nullptr) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return participant_->create_subscriber(group_qos())
        .create_datareader<T>(**on, reader_qos(), listener);
  }

  std::int64_t nanoseconds() const { return runtime_.clock().monotonic().count(); }
  /// True if the timeout has passed or a signal arrived.
  bool is_over() const;
  /// Waits in steps of one millisecond until `ready` returns true. Returns false if the session was
  /// over before.
  bool wait_until(const std::function<bool()>& ready) const;
  /// Prints `matched` if the count differs from the last one printed for `what`.
  void note_matched(const char* what, std::int32_t current);

  Counts counts;
  /// Prints `done` and `exit`. Returns the exit code.
  int finish(int code);

 private:
  void raise(const Event& event) override;
  /// Prints `auth` for each peer that has authenticated or failed since the last call.
  void note_authenticated();
  template <class T>
  Result<rtps::Topic*> topic_of(const std::string& name) {
    if (auto* known = participant_->lookup_topicdescription(name)) return known;
    return participant_->create_topic<T>(name);
  }
  rtps::Qos writer_qos(bool keep_all) const;
  rtps::Qos reader_qos() const;
  rtps::GroupQos group_qos() const;

  const Options options_;
  secured::Runtime runtime_{*this};
  std::unique_ptr<rtps::DomainParticipant> participant_;
  rtps::AuthenticationCounters printed_;
  std::int64_t end_ = 0;
  std::int32_t last_printed_ = 0;
};

int run_pub(Session& session);
int run_sub(Session& session);
int run_ping(Session& session);
int run_pong(Session& session);
int run_tput_pub(Session& session);
int run_tput_sub(Session& session);

/// Returns the number of remote endpoints that are matched now.
template <class T>
std::int32_t matched_count(rtps::DataWriter<T>& writer) {
  return writer.publication_matched_status().current_count;
}
template <class T>
std::int32_t matched_count(rtps::DataReader<T>& reader) {
  return reader.subscription_matched_status().current_count;
}

/// Prints `error` for a failed creation. Returns the exit code for it.
int print_refusal(const Error& error);

}  // namespace ddssec::peer
