#include "rtps/dcps/subscriber.hpp"

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

Subscriber::Subscriber(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Group(participant, context, std::move(qos), default_reader_qos(), "subscriber") {}

void Subscriber::set_listener(SubscriberListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

SubscriberListener* Subscriber::listener_for(StatusKind kind) const {
  if (auto* own = listening_.for_status(kind)) return own;
  return participant_.listening_.for_status(kind);
}

AnyDataReader* Subscriber::lookup_datareader(std::string_view topic_name) const {
  return static_cast<AnyDataReader*>(lookup(topic_name));
}

std::vector<AnyDataReader*> Subscriber::datareaders(const States& states) const {
  const auto held = lock();
  std::vector<AnyDataReader*> out;
  for (const auto& member : members_) {
    auto& reader = static_cast<AnyDataReader&>(*member);  // a subscriber creates nothing else
    if (reader.cache_->any(states)) out.push_back(&reader);
  }
  return out;
}

void Subscriber::notify_datareaders() {
  const std::lock_guard members(context_.callbacks());
  for (auto* reader : datareaders({.sample = SampleState::not_read})) {
    DataReaderListener* listener = nullptr;
    {
      const auto held = lock();
      listener = reader->listener_for(StatusKind::data_available);
      if (listener != nullptr) reader->clear(StatusKind::data_available);
    }
    if (listener != nullptr) listener->on_data_available(*reader);
  }
}

}  // namespace ddssec::rtps
