#include "rtps/dcps/subscriber.hpp"

#include <algorithm>

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

Subscriber::Subscriber(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Group(participant, context, std::move(qos), default_reader_qos(), "subscriber") {}

void Subscriber::set_listener(SubscriberListener* listener, StatusMask mask) {
  replace_listener([&] { return listening_.set(listener, mask); });
}

AnyDataReader* Subscriber::lookup_datareader(std::string_view topic_name) const {
  return static_cast<AnyDataReader*>(lookup(topic_name));
}

std::vector<AnyDataReader*> Subscriber::datareaders(const States& states) const {
  const auto held = lock();
  const auto& presentation = presentation_of_members();
  const bool one_by_one =
      presentation.ordered_access && presentation.scope == PresentationScope::group;
  std::vector<std::pair<std::uint64_t, AnyDataReader*>> found;
  for (const auto& member : members_) {
    auto& reader = static_cast<AnyDataReader&>(*member);  // a subscriber creates nothing else
    if (!one_by_one && reader.reception_.cache().any(states)) found.emplace_back(0, &reader);
    if (one_by_one)
      for (const auto arrival : arrivals(reader.reception_.cache().held(), states))
        found.emplace_back(arrival, &reader);
  }
  if (one_by_one) std::ranges::sort(found);
  std::vector<AnyDataReader*> out;
  for (const auto& [arrival, reader] : found) out.push_back(reader);
  return out;
}

Presenter* Subscriber::presenter(const Presentation& presentation) {
  if (presentation.scope != PresentationScope::group) return nullptr;
  const bool needed = presentation.coherent_access || presentation.ordered_access;
  if (needed && !presenter_)
    presenter_ = std::make_unique<Presenter>(
        Presenter::PresentedAccess{.is_by_group = true,
                                   .is_coherent = presentation.coherent_access,
                                   .is_ordered = presentation.ordered_access});
  return presenter_.get();
}

// Checks that the application may access samples now (DDS 1.4, 2.2.2.5.2.8).
Status Subscriber::check_access() const {
  if (!presenter_ || accesses_ > 0) return {};
  return precondition_not_met_error("subscriber with GROUP access", "begin_access before", "none");
}

Status Subscriber::begin_access() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("subscriber"));
  if (accesses_++ == 0) pause(true);
  return {};
}

Status Subscriber::end_access() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("subscriber"));
  if (accesses_ == 0)
    return precondition_not_met_error("subscriber", "begin_access before", "none");
  if (--accesses_ == 0) pause(false);
  context_.reschedule();
  return {};
}

void Subscriber::pause(bool paused) {
  const auto now = context_.now();
  for (const auto& member : members_)
    static_cast<AnyDataReader&>(*member).reception_.pause(paused, now);
  if (!presenter_) return;
  presenter_->pause(paused, now);
  if (!paused && !members_.empty())
    static_cast<AnyDataReader&>(*members_.front()).reception_.schedule_presenter();
}

void Subscriber::notify_datareaders() {
  {
    const ParticipantContext::CallingScope calling(context_, CallbackLock::Wait::while_it_ends);
    if (!calling) return;
    for (auto* reader : datareaders({.sample = SampleState::not_read}))
      reader->listeners_.notify_of_data_available(*reader,
                                                  {reader->changes_, changes_, context_.mutex()});
  }
  const auto held = lock();
  context_.reschedule();
}

}  // namespace ddssec::rtps
