// A secured participant in one call: for applications that want samples and not the entities of
// DDS around them. Everything else of DDS is behind `dds()`.
#pragma once

#include "rtps/dcps/domain_participant.hpp"
#include "secured/engines.hpp"

namespace ddssec::secured {

/// Each a line on standard error, from warnings on, and which interfaces a participant uses and
/// which peers it authenticated. What a call of the application returns as an error is not printed:
/// that is for the application to do.
class StandardErrorEvents final : public EventSink {
 public:
  void raise(const Event& event) override;
};

/// A domain participant with its clock, its random source and its engines, one publisher and one
/// subscriber. Movable; what its calls return belongs to it and dies with it. Thread-safe.
class Participant {
 public:
  /// Joins a domain with the identity, permissions and governance of `folder`, as `ddssec init`
  /// makes it. Refusals of peers go to `events`, which outlives the participant; without any, to
  /// standard error. Errors: file_unreadable, those of the plugins, those of
  /// rtps::DomainParticipant::create; each sentence names the document and what to do.
  static Result<Participant> join(const std::filesystem::path& folder,
                                  rtps::DomainParticipantOptions options = {},
                                  EventSink* events = nullptr);

  /// Reliable, and otherwise as DDS has it by default. For a policy of your own change one of
  /// these: in a Qos made by hand RELIABILITY is BEST_EFFORT, as DDS has it for readers.
  static rtps::Qos writer_qos();
  static rtps::Qos reader_qos();

  /// A writer with writer_qos(), or with `qos`. Errors: those of access control (the
  /// permissions do not allow it), rtps_bad_parameter (the topic has another type),
  /// rtps_qos_inconsistent.
  template <rtps::DdsType T>
  Result<rtps::DataWriter<T>*> writer(const std::string& topic, std::optional<rtps::Qos> qos = {}) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return state_->publisher->create_datawriter<T>(**on, std::move(qos).value_or(writer_qos()));
  }
  /// A reader with reader_qos(), or with `qos`. Errors: as of writer.
  template <rtps::DdsType T>
  Result<rtps::DataReader<T>*> reader(const std::string& topic, std::optional<rtps::Qos> qos = {}) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return state_->subscriber->create_datareader<T>(**on, std::move(qos).value_or(reader_qos()));
  }

  /// Makes new keys for those who are trusted now; see rtps::DomainParticipant::revise_keys.
  Status revise_keys() { return dds().revise_keys(); }

  rtps::DomainParticipant& dds() { return *state_->participant; }

 private:
  struct State {
    explicit State(EventSink* sink) : events(sink != nullptr ? *sink : standard_error) {}
    SystemClock clock;
    SystemRandom random;
    StandardErrorEvents standard_error;
    EventSink& events;
    RateLimitedSink limited{events, clock};
    Engines engines{{clock, random, limited}};
    std::unique_ptr<rtps::DomainParticipant> participant = {};
    rtps::Publisher* publisher = nullptr;
    rtps::Subscriber* subscriber = nullptr;
  };

  explicit Participant(std::unique_ptr<State> state) : state_(std::move(state)) {}
  template <rtps::DdsType T>
  Result<rtps::Topic*> topic_of(const std::string& name) {
    if (auto* known = dds().lookup_topicdescription(name)) return known;
    return dds().create_topic<T>(name);
  }

  std::unique_ptr<State> state_;
};

/// Writes the error's sentence to standard error and ends the process with status 1.
[[noreturn]] void exit_with(const Error& error);

/// The value; for programs that cannot go on without it (see exit_with).
template <class T>
T or_exit(Result<T> result) {
  if (!result) exit_with(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace ddssec::secured
