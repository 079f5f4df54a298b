#include "secured/participant.hpp"

#include <cstdio>
#include <cstdlib>

#include "secured/runtime.hpp"

namespace ddssec::secured {

struct Participant::State {
  explicit State(EventSink* sink) : runtime(sink != nullptr ? *sink : standard_error) {}
  StandardErrorEvents standard_error;
  Runtime runtime;
  std::unique_ptr<rtps::DomainParticipant> participant = {};
  rtps::Publisher* publisher = nullptr;
  rtps::Subscriber* subscriber = nullptr;
};

Participant::Participant(std::unique_ptr<State> state) : state_(std::move(state)) {}
Participant::~Participant() = default;
Participant::Participant(Participant&&) noexcept = default;
Participant& Participant::operator=(Participant&&) noexcept = default;

rtps::DomainParticipant& Participant::dds() { return *state_->participant; }
rtps::Publisher& Participant::publisher() { return *state_->publisher; }
rtps::Subscriber& Participant::subscriber() { return *state_->subscriber; }

void StandardErrorEvents::raise(const Event& event) {
  if (event.is_returned) return;
  if (event.severity >= Severity::warning || is_always_shown(event.error.code()))
    std::fprintf(stderr, "%s\n", event.to_line().c_str());
}

Result<Participant> Participant::join(const std::filesystem::path& folder,
                                      rtps::DomainParticipantOptions options, EventSink* events) {
  auto state = std::make_unique<State>(events);
  DDSSEC_ASSIGN_OR_RETURN(auto security, state->runtime.plugins().security_options(folder));
  options.security.emplace(std::move(security));
  DDSSEC_ASSIGN_OR_RETURN(state->participant, rtps::DomainParticipant::create(
                                                  std::move(options), state->runtime.services()));
  state->publisher = &state->participant->create_publisher();
  state->subscriber = &state->participant->create_subscriber();
  return Participant(std::move(state));
}

rtps::Qos Participant::writer_qos() { return rtps::default_writer_qos(); }

rtps::Qos Participant::reader_qos() {
  auto qos = rtps::default_reader_qos();
  qos.reliability.kind = rtps::ReliabilityKind::reliable;
  return qos;
}

void exit_with(const Error& error) {
  std::fprintf(stderr, "%s\n", error.to_sentence().c_str());
  std::exit(EXIT_FAILURE);
}

}  // namespace ddssec::secured
