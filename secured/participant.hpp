// A secured participant in one call, for applications that need samples and not the DDS entities
// around them. `dds()` gives access to the rest of DDS.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "base/event.hpp"
#include "base/result.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::secured {

/// Prints events to standard error, one line each: warnings and errors, the interfaces that a
/// participant uses, each peer that it authenticated, and documents that were renewed. An error
/// that a call returns to the application is not printed; the application reports it. Waits while
/// standard error is a pipe that is full.
class StandardErrorEvents final : public EventSink {
 public:
  void raise(const Event& event) override;
};

/// A domain participant with its clock, random source, security plugins, one publisher and one
/// subscriber. Movable. Owns the writers and readers that its calls return; they are destroyed with
/// it. Thread-safe. Must not be destroyed within one of its listeners (~DomainParticipant).
class Participant {
 public:
  ~Participant();
  /// A participant that was moved from may only be destroyed or assigned to.
  Participant(Participant&&) noexcept;
  Participant& operator=(Participant&&) noexcept;

  /// Joins a domain with the identity, permissions and governance in `folder`, which `ddssec init`
  /// creates. Refusals of peers are reported to `events`, which must outlive the participant; if it
  /// is nullptr, they are printed to standard error. All events are also appended to the file that
  /// the environment variable DDSSEC_EVENT_LOG names. `options.security` is replaced by the plugins
  /// and the documents of the folder.
  /// Errors: those of folder_properties, invalid_property (org.ddssec.clock_step_grace), those of
  /// the security plugins, those of rtps::DomainParticipant::create. Each message names the
  /// document and what to do.
  static Result<Participant> join(const std::filesystem::path& folder,
                                  rtps::DomainParticipantOptions options = {},
                                  EventSink* events = nullptr);

  /// Each returns policies with which RELIABILITY is RELIABLE; all other policies have the defaults
  /// of DDS. To change a policy, start from one of these: in a default-constructed Qos, RELIABILITY
  /// is BEST_EFFORT, the DDS default for readers.
  static rtps::Qos writer_qos();
  static rtps::Qos reader_qos();

  /// Creates a writer with `qos`, or with writer_qos() if none is given; creates the topic if
  /// needed. Each call creates another writer, which lives as long as the participant. Errors:
  /// those of access control (the permissions do not allow it), rtps_bad_parameter (the topic
  /// exists with another type, or its name is empty or longer than 256 characters),
  /// rtps_precondition_not_met (a content-filtered topic has the name), rtps_qos_inconsistent.
  template <rtps::DdsType T>
  Result<rtps::DataWriter<T>*> create_writer(const std::string& topic,
                                             std::optional<rtps::Qos> qos = {}) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return publisher().create_datawriter<T>(**on, std::move(qos).value_or(writer_qos()));
  }
  /// Creates a reader with `qos`, or with reader_qos() if none is given. Ownership and errors as
  /// for create_writer().
  template <rtps::DdsType T>
  Result<rtps::DataReader<T>*> create_reader(const std::string& topic,
                                             std::optional<rtps::Qos> qos = {}) {
    const auto on = topic_of<T>(topic);
    if (!on) return std::unexpected(on.error());
    return subscriber().create_datareader<T>(**on, std::move(qos).value_or(reader_qos()));
  }

  /// Creates new keys and gives them to the peers that are trusted now; see
  /// rtps::DomainParticipant::revise_keys. Errors: rtps_key_revision_disabled.
  Status revise_keys() { return dds().revise_keys(); }

  /// Returns the participant for everything else of DDS: listeners, further publishers and
  /// subscribers, conditions, discovered participants. It lives as long as this object.
  rtps::DomainParticipant& dds();

 private:
  struct State;

  explicit Participant(std::unique_ptr<State> state);
  rtps::Publisher& publisher();
  rtps::Subscriber& subscriber();
  template <rtps::DdsType T>
  Result<rtps::Topic*> topic_of(const std::string& name) {
    if (auto* known = dds().lookup_topicdescription(name)) return known;
    auto made = dds().create_topic<T>(name);
    if (made) return made;
    // Another thread may have created it since the look-up.
    if (auto* known = dds().lookup_topicdescription(name)) return known;
    return made;
  }

  std::unique_ptr<State> state_;
};

/// Prints the error's sentence to standard error and exits the process with status 1.
[[noreturn]] void exit_with(const Error& error);

/// Returns the value, or exits as exit_with does. For programs that cannot continue without the
/// value.
template <class T>
T or_exit(Result<T> result) {
  if (!result) exit_with(result.error());
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}

}  // namespace ddssec::secured
