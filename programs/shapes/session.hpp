// What publisher and subscriber share: the participant, its statuses as lines, policies, the end.
#pragma once

#include <memory>

#include "programs/shapes/options.hpp"
#include "programs/shapes/types.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "secured/engines.hpp"

namespace ddssec::shapes {

/// One line on standard output, flushed; printf's format without the line's end.
[[gnu::format(printf, 1, 2)]] void say(const char* format, ...);

/// "Square     BLUE       007 012 [20]", and " {255}" for the last octet of a payload.
template <class T>
void say_sample(const std::string& topic, const T& shape) {
  if constexpr (requires { shape.additional_payload_size; }) {
    if (const auto& payload = shape.additional_payload_size; !payload.empty())
      return say("%-10s %-10s %03d %03d [%d] {%d}", topic.c_str(), shape.color.c_str(), shape.x,
                 shape.y, shape.shapesize, int{payload.back()});
  }
  say("%-10s %-10s %03d %03d [%d]", topic.c_str(), shape.color.c_str(), shape.x, shape.y,
      shape.shapesize);
}

/// Blocks SIGINT and SIGTERM in this thread and those it starts: `Session::pause` waits for them.
void hold_signals();

/// Says each status that a shapes program tells of.
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

class Session final : private EventSink {
 public:
  explicit Session(const Options& options) : options_(options) {}
  ~Session() override;

  /// Errors: those of secured::folder_properties and DomainParticipant::create.
  Status open();
  const Options& options() const { return options_; }
  rtps::DomainParticipant& participant() { return *participant_; }
  Random& random() { return random_; }

  /// TOPIC, TOPIC1...
  template <class T>
  Result<std::vector<rtps::Topic*>> create_topics() {
    std::vector<rtps::Topic*> out;
    for (std::uint32_t i = 0; i < options_.topics; ++i) {
      const auto name = Options::numbered(options_.topic, i);
      say("Create topic: %s", name.c_str());
      out.push_back(DDSSEC_TRY(participant_->create_topic<T>(name)));
    }
    return out;
  }
  /// What -c of a subscriber and --cft ask for.
  std::optional<rtps::FilterText> filter() const;
  rtps::GroupQos group_qos() const;
  rtps::Qos writer_qos() const;
  rtps::Qos reader_qos() const;

  /// Waits so many milliseconds; false: the program is to end.
  bool pause(std::int64_t milliseconds);

 private:
  void raise(const Event& event) override;
  /// The file of --durability-directory; empty: none. Errors: rtps_store_unusable.
  Result<std::string> store() const;
  rtps::Qos common_qos() const;

  const Options options_;
  SystemClock clock_;
  SystemRandom random_;
  RateLimitedSink limited_{*this, clock_};
  StatusLines lines_;
  secured::Engines engines_{{clock_, random_, limited_}};
  std::unique_ptr<rtps::DomainParticipant> participant_;
};

/// The exit codes of both roles; "failed to create ..." was said.
template <class T>
int run_publisher(Session& session);
template <class T>
int run_subscriber(Session& session);

/// Says it on standard output; the exit code for it.
int not_created(const char* what, const Error& error);

}  // namespace ddssec::shapes
