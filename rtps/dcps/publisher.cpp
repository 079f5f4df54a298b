#include "rtps/dcps/publisher.hpp"

#include <algorithm>

#include "base/hash.hpp"
#include "rtps/dcps/domain_participant.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

Publisher::Publisher(DomainParticipant& participant, ParticipantContext& context, GroupQos qos)
    : Group(participant, context, std::move(qos), default_writer_qos(), "publisher") {}

void Publisher::set_listener(PublisherListener* listener, StatusMask mask) {
  replace_listener([&] { return listening_.set(listener, mask); });
}

AnyDataWriter* Publisher::lookup_datawriter(std::string_view topic_name) const {
  return static_cast<AnyDataWriter*>(lookup(topic_name));
}

Status Publisher::wait_for_acknowledgments(std::chrono::nanoseconds timeout) {
  constexpr std::chrono::nanoseconds kMax = std::chrono::hours(24 * 365);
  const auto end = std::chrono::steady_clock::now() + std::min(timeout, kMax);
  std::vector<AnyDataWriter*> writers;
  {
    const auto held = lock();
    for (const auto& member : members_) writers.push_back(&writer_of(member));
  }
  for (auto* writer : writers) {
    const std::chrono::nanoseconds left = end - std::chrono::steady_clock::now();
    DDSSEC_RETURN_IF_ERROR(
        writer->wait_for_acknowledgments(std::max(left, std::chrono::nanoseconds::zero())));
  }
  return {};
}

// PRESENTATION cannot change once the publisher is enabled, and a writer is enabled after its
// publisher.
std::optional<Guid> Publisher::group_guid() {
  const auto& presentation = presentation_of_members();
  presents_ = presentation.coherent_access || presentation.ordered_access;
  is_by_group_ = presents_ && presentation.scope == PresentationScope::group;
  presents_ = presentation.coherent_access || is_by_group_;
  if (is_by_group_ && !guid_) guid_ = context_.protocol().create_group();
  return guid_;
}

void Publisher::admit(StatefulWriter& writer) {
  if (is_suspended_) writer.suspend();
  if (is_by_group_) writer.join(group_);
}

// The hash is the first octets of the MD5 of the sorted entity ids in big-endian CDR (RTPS
// 9.3.2.5).
void Publisher::count_writers() {
  std::vector<EntityId> ids;
  for (const auto& member : members_)
    if (writer_of(member).enabled()) ids.push_back(writer_of(member).guid_.entity);
  const auto number = [](const EntityId& id) {
    const auto& o = id.octets;
    return static_cast<std::int32_t>(o[0] | o[1] << 8 | o[2] << 16 |
                                     static_cast<std::int32_t>(std::uint32_t{o[3]} << 24));
  };
  std::ranges::sort(ids, {}, number);
  Bytes octets{static_cast<std::uint8_t>(ids.size() >> 24),
               static_cast<std::uint8_t>(ids.size() >> 16),
               static_cast<std::uint8_t>(ids.size() >> 8), static_cast<std::uint8_t>(ids.size())};
  for (const auto& id : ids) octets.insert(octets.end(), id.octets.begin(), id.octets.end());
  group_.writers = {};
  if (ids.empty()) return;
  const auto digest = md5(octets);
  std::copy_n(digest.begin(), group_.writers.size(), group_.writers.begin());
}

CoherentSetInfo Publisher::stamp(SequenceNumber& set_begin, SequenceNumber number) {
  CoherentSetInfo out;
  if (is_by_group_) out.group = group_.current = group_.current.next();
  if (depth_ == 0 || !presentation_of_members().coherent_access) return out;
  if (set_begin.value == 0) set_begin = number;
  out.set = set_begin;
  if (!is_by_group_) return out;
  if (set_begin_.value == 0) set_begin_ = out.group;
  out.group_set = set_begin_;
  return out;
}

Status Publisher::begin_coherent_changes() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("publisher"));
  ++depth_;
  return {};
}

Status Publisher::end_coherent_changes() {
  const std::lock_guard members(context_.members());
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("publisher"));
  if (depth_ == 0)
    return precondition_not_met_error("publisher", "begin_coherent_changes before", "none");
  if (--depth_ > 0) return {};
  CoherentSetInfo marker;
  if (set_begin_.value > 0) {
    count_writers();
    marker.group_set = std::exchange(set_begin_, {});
    marker.group = group_.current = group_.current.next();
    marker.writers = group_.writers;
  }
  const auto now = context_.now();
  {
    // The ends are sent in one message, so that readers of several topics see them at the same
    // time.
    const auto gathering = context_.protocol().gather();
    for (const auto& member : members_) writer_of(member).end_set(marker, now);
  }
  context_.reschedule();
  return {};
}

Status Publisher::suspend_publications() {
  const std::lock_guard members(context_.members());
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("publisher"));
  is_suspended_ = true;
  for (const auto& member : members_)
    if (writer_of(member).enabled()) writer_of(member).protocol().suspend();
  return {};
}

Status Publisher::resume_publications() {
  const std::lock_guard members(context_.members());
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("publisher"));
  if (!std::exchange(is_suspended_, false))
    return precondition_not_met_error("publisher", "suspend_publications before", "none");
  for (const auto& member : members_)
    if (writer_of(member).enabled()) writer_of(member).protocol().resume(context_.now());
  context_.reschedule();
  return {};
}

}  // namespace ddssec::rtps
