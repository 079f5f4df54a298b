#include "rtps/dcps/publisher.hpp"

#include <algorithm>

namespace ddssec::rtps {

Publisher::Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Group(participant, context, std::move(qos), default_writer_qos(), "publisher") {}

void Publisher::set_listener(PublisherListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

AnyDataWriter* Publisher::lookup_datawriter(std::string_view topic_name) const {
  return static_cast<AnyDataWriter*>(lookup(topic_name));
}

Status Publisher::wait_for_acknowledgments(std::chrono::nanoseconds most) {
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365);
  const auto end = std::chrono::steady_clock::now() + std::min(most, kLongest);
  std::vector<AnyDataWriter*> writers;
  {
    const auto held = lock();
    for (const auto& member : members_) writers.push_back(&writer_of(member));
  }
  for (auto* writer : writers) {
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    DDSSEC_TRY(writer->wait_for_acknowledgments(std::max(left, std::chrono::nanoseconds::zero())));
  }
  return {};
}

}  // namespace ddssec::rtps
