#include "rtps/dcps/groups.hpp"

#include <cassert>

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/no_callbacks.hpp"

namespace ddssec::rtps {

// Enabling a new group cannot fail: the participant is enabled, and the group has no members yet.
void Groups::enable_if_due(Group& group) const {
  if (!participant_.is_enabled() || !participant_.qos().autoenable_created_entities) return;
  [[maybe_unused]] const auto enabled = group.enable();
  assert(enabled);
}

Publisher& Groups::create_publisher(GroupQos qos, PublisherListener* listener, StatusMask mask) {
  std::unique_ptr<Publisher> publisher(new Publisher(participant_, context_, std::move(qos)));
  publisher->set_listener(listener, mask);
  const std::lock_guard members(context_.members());
  enable_if_due(*publisher);
  return *publishers_.add(std::move(publisher));
}

Subscriber& Groups::create_subscriber(GroupQos qos, SubscriberListener* listener, StatusMask mask) {
  std::unique_ptr<Subscriber> subscriber(new Subscriber(participant_, context_, std::move(qos)));
  subscriber->set_listener(listener, mask);
  const std::lock_guard members(context_.members());
  enable_if_due(*subscriber);
  return *subscribers_.add(std::move(subscriber));
}

Status Groups::remove(Publisher& publisher) {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  const std::lock_guard members(context_.members());
  return publishers_.remove(publisher, publisher.members_.empty());
}

Status Groups::remove(Subscriber& subscriber) {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  const std::lock_guard members(context_.members());
  return subscribers_.remove(subscriber, subscriber.members_.empty());
}

Status Groups::enable() {
  for (const auto& publisher : publishers_.all()) DDSSEC_RETURN_IF_ERROR(publisher->enable());
  for (const auto& subscriber : subscribers_.all()) DDSSEC_RETURN_IF_ERROR(subscriber->enable());
  return {};
}

Status Groups::announce_again(const Topic& topic) {
  const std::lock_guard members(context_.members());
  const auto each = [&](const auto& groups) -> Status {
    for (const auto& group : groups)
      for (auto& member : group->members_)
        if (&member->topic() == &topic) DDSSEC_RETURN_IF_ERROR(member->regroup(group->qos()));
    return {};
  };
  DDSSEC_RETURN_IF_ERROR(each(publishers_.all()));
  return each(subscribers_.all());
}

void Groups::conclude_writers() {
  std::vector<std::unique_ptr<Endpoint>> dying;
  {
    const std::lock_guard members(context_.members());
    const std::lock_guard held(context_.mutex());
    for (const auto& publisher : publishers_.all())
      std::ranges::move(std::exchange(publisher->members_, {}), std::back_inserter(dying));
  }
  Group::conclude(dying);
}

}  // namespace ddssec::rtps
