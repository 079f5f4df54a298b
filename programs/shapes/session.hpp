// The participant, printing of its statuses, policies and termination, which publisher and
// subscriber share.
#pragma once

#include <memory>

#include "programs/shapes/options.hpp"
#include "programs/shapes/types.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "secured/runtime.hpp"

namespace ddssec::shapes {

/// Prints one line on standard output and flushes it. The format is that of printf, without the end
/// of line.
[[gnu::format(printf, 1, 2)]] void print_line(const char* format, ...);

/// Prints a line such as "Square     BLUE       007 012 [20]", followed by " {255}" for the last
/// octet of a payload.
template <class T>
void print_sample(const std::string& topic, const T& shape) {
  if constexpr (requires { shape.additional_payload_size; }) {
    if (const auto& payload = shape.additional_payload_size; !payload.empty())
      return print_line("%-10s %-10s %03d %03d [%d] {%d}", topic.c_str(), shape.color.c_str(),
                        shape.x, shape.y, shape.shapesize, int{payload.back()});
  }
  print_line("%-10s %-10s %03d %03d [%d]", topic.c_str(), shape.color.c_str(), shape.x, shape.y,
             shape.shapesize);
}

/// Blocks SIGINT and SIGTERM in this thread and in those that it starts. `Session::pause` waits for
/// them.
void hold_signals();

/// Prints each status that a shapes program reports.
class StatusLines final : public rtps::DomainParticipantListener {
  void on_publication_matched(rtps::AnyDataWriter&, const rtps::MatchedStatus&) override;
  void on_offered_incompatible_qos(rtps::AnyDataWriter&,
                                   const rtps::IncompatibleQosStatus&) override;
  void on_offered_deadline_missed(rtps::AnyDataWriter&, const rtps::DeadlineMissedStatus&) override;
  void on_liveliness_lost(rtps::AnyDataWriter&, const rtps::LivelinessLostStatus&) override;
  void on_subscription_matched(rtps::AnyDataReader&, const rtps::MatchedStatus&) override;
  void on_requested_incompatible_qos(rtps::AnyDataReader&,
                                     const rtps::IncompatibleQosStatus&) override;
  void on_requested_deadline_missed(rtps::AnyDataReader&,
                                    const rtps::DeadlineMissedStatus&) override;
  void on_liveliness_changed(rtps::AnyDataReader&, const rtps::LivelinessChangedStatus&) override;
  void on_inconsistent_topic(rtps::Topic&, const rtps::InconsistentTopicStatus&) override;
};

/// The participant of one run of the program.
class Session final : private EventSink {
 public:
  explicit Session(const Options& options) : options_(options) {}
  ~Session() override;

  /// Creates the participant. Errors: those of SecurityPluginSet::security_options and
  /// DomainParticipant::create.
  Status open();
  const Options& options() const { return options_; }
  rtps::DomainParticipant& participant() { return *participant_; }
  Random& random() { return runtime_.random(); }

  /// Creates the topics TOPIC, TOPIC1...
  template <class T>
  Result<std::vector<rtps::Topic*>> create_topics() {
    std::vector<rtps::Topic*> out;
    for (std::uint32_t i = 0; i < options_.topics; ++i) {
      const auto name = Options::numbered(options_.topic, i);
      print_line("Create topic: %s", name.c_str());
      DDSSEC_ASSIGN_OR_RETURN(const auto topic, participant_->create_topic<T>(name));
      out.push_back(topic);
    }
    return out;
  }
  /// Returns the filter that -c of a subscriber or --cft requests; empty if there is none.
  std::optional<rtps::FilterText> filter() const;
  rtps::GroupQos group_qos() const;
  rtps::Qos writer_qos() const;
  rtps::Qos reader_qos() const;

  /// Waits for this many milliseconds. Returns false if the program must end.
  bool pause(std::int64_t milliseconds);

 private:
  void raise(const Event& event) override;
  /// Returns the path of the file in --durability-directory; empty if no store is used. Errors:
  /// rtps_store_unusable.
  Result<std::string> store() const;
  rtps::Qos common_qos() const;

  const Options options_;
  secured::Runtime runtime_{*this};
  StatusLines lines_;
  std::unique_ptr<rtps::DomainParticipant> participant_;
};

/// Both return the exit code. "failed to create ..." has been printed if that is the reason.
template <class T>
int run_publisher(Session& session);
template <class T>
int run_subscriber(Session& session);

/// Prints the failure and returns the exit code for it.
int not_created(const char* what, const Error& error);

}  // namespace ddssec::shapes
