// DomainParticipant, the half that is about its entities and policies.
#include <algorithm>

#include <fmt/format.h>

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

DomainParticipantQos DomainParticipant::qos() const {
  const auto held = lock();
  return qos_;
}

Status DomainParticipant::set_qos(const DomainParticipantQos& qos) {
  const auto held = lock();
  if (qos.user_data != qos_.user_data) context_.protocol().change_user_data(qos.user_data);
  qos_ = qos;
  context_.reschedule();
  return {};
}

void DomainParticipant::set_listener(DomainParticipantListener* listener, StatusMask mask) {
  const std::lock_guard callbacks(context_.callbacks());
  const auto held = lock();
  listening_ = {listener, mask};
}

Qos DomainParticipant::default_topic_qos() const {
  const auto held = lock();
  return default_topic_qos_;
}

Status DomainParticipant::set_default_topic_qos(const Qos& qos) {
  DDSSEC_TRY(check_consistency(qos));
  const auto held = lock();
  default_topic_qos_ = qos;
  return {};
}

Status DomainParticipant::check_name(std::string_view name) {
  if (!name.empty() && name.size() <= kMostNameLength) return {};
  return fail(Code::rtps_bad_parameter, {.document = "topic " + std::string(name),
                                         .field = "name of topic or type",
                                         .expected = "1 to 256 characters",
                                         .found = std::to_string(name.size())});
}

Status DomainParticipant::check_new_name(std::string_view name) const {
  const bool is_topic = lookup_topicdescription(name) != nullptr;
  if (!is_topic && lookup_contentfilteredtopic(name) == nullptr) return {};
  return fail(Code::rtps_precondition_not_met,
              {.document = fmt::format("topic {}", name),
               .expected = "a new name",
               .found = is_topic ? "that of a topic" : "that of a content-filtered topic",
               .hint = fmt::format(
                   "{}(\"{}\") returns the one that has the name; or choose another",
                   is_topic ? "lookup_topicdescription" : "lookup_contentfilteredtopic", name)});
}

Result<Topic*> DomainParticipant::create_topic(std::string name, TypeSupport type,
                                               std::optional<Qos> qos, TopicListener* listener,
                                               StatusMask mask) {
  DDSSEC_TRY(check_name(name));
  DDSSEC_TRY(check_name(type.name));
  const auto policies = std::move(qos).value_or(default_topic_qos());
  DDSSEC_TRY(check_consistency(policies));
  const std::lock_guard members(context_.callbacks());
  DDSSEC_TRY(check_new_name(name));
  if (!options_.announce_types) type.description = {};
  std::unique_ptr<Topic> topic(
      new Topic(*this, context_, std::move(name), std::move(type), policies));
  topic->set_listener(listener, mask);
  if (is_enabled() && this->qos().autoenable_created_entities) DDSSEC_TRY(topic->enable());
  const auto held = lock();
  topics_.push_back(std::move(topic));
  context_.notify();  // somebody may be looking for it
  return topics_.back().get();
}

Topic* DomainParticipant::lookup_topicdescription(std::string_view name) const {
  const auto held = lock();
  const auto at =
      std::ranges::find(topics_, name, [](const auto& t) -> std::string_view { return t->name(); });
  return at == topics_.end() ? nullptr : at->get();
}

Result<Publisher*> DomainParticipant::create_publisher(GroupQos qos, PublisherListener* listener,
                                                       StatusMask mask) {
  std::unique_ptr<Publisher> publisher(new Publisher(*this, context_, std::move(qos)));
  publisher->set_listener(listener, mask);
  const std::lock_guard members(context_.callbacks());
  if (is_enabled() && this->qos().autoenable_created_entities) DDSSEC_TRY(publisher->enable());
  const auto held = lock();
  publishers_.push_back(std::move(publisher));
  return publishers_.back().get();
}

Result<Subscriber*> DomainParticipant::create_subscriber(GroupQos qos, SubscriberListener* listener,
                                                         StatusMask mask) {
  std::unique_ptr<Subscriber> subscriber(new Subscriber(*this, context_, std::move(qos)));
  subscriber->set_listener(listener, mask);
  const std::lock_guard members(context_.callbacks());
  if (is_enabled() && this->qos().autoenable_created_entities) DDSSEC_TRY(subscriber->enable());
  const auto held = lock();
  subscribers_.push_back(std::move(subscriber));
  return subscribers_.back().get();
}

template <class Child>
Status DomainParticipant::delete_child(std::vector<std::unique_ptr<Child>>& children, Child& child,
                                       bool unused) {
  DDSSEC_TRY(check_not_in_callback(context_));
  const std::lock_guard members(context_.callbacks());
  std::unique_ptr<Child> dying;
  const auto held = lock();
  const auto at = std::ranges::find(children, &child, &std::unique_ptr<Child>::get);
  if (at == children.end())
    return precondition_not_met("entity", "one of this participant", "another's");
  if (!unused) return precondition_not_met("entity", "one that is empty and unused", "a used one");
  dying = std::move(*at);
  children.erase(at);
  return {};  // the lock ends before the entity does
}

template Status DomainParticipant::delete_child(std::vector<std::unique_ptr<ContentFilteredTopic>>&,
                                                ContentFilteredTopic&, bool);

Status DomainParticipant::delete_topic(Topic& topic) {
  const std::lock_guard members(context_.callbacks());
  bool unused = false;
  {
    const auto held = lock();
    unused = topic.users_ == 0;
    if (unused && topic.references_ > 1) {
      --topic.references_;
      return {};
    }
  }
  return delete_child(topics_, topic, unused);
}

Status DomainParticipant::delete_publisher(Publisher& publisher) {
  const std::lock_guard members(context_.callbacks());
  return delete_child(publishers_, publisher, publisher.members_.empty());
}

Status DomainParticipant::delete_subscriber(Subscriber& subscriber) {
  const std::lock_guard members(context_.callbacks());
  return delete_child(subscribers_, subscriber, subscriber.members_.empty());
}

Status DomainParticipant::delete_contained_entities() {
  DDSSEC_TRY(check_not_in_callback(context_));
  conclude();
  const std::lock_guard members(context_.callbacks());
  decltype(topics_) topics;
  decltype(filtered_topics_) filtered;
  decltype(publishers_) publishers;
  decltype(subscribers_) subscribers;
  const auto held = lock();
  topics.swap(topics_);
  filtered.swap(filtered_topics_);
  publishers.swap(publishers_);
  subscribers.swap(subscribers_);
  return {};  // subscribers and publishers go before the topics
}

void DomainParticipant::conclude() {
  std::vector<std::unique_ptr<Endpoint>> dying;
  {
    const std::lock_guard members(context_.callbacks());
    const auto held = lock();
    for (auto& publisher : publishers_)
      std::ranges::move(std::exchange(publisher->members_, {}), std::back_inserter(dying));
  }
  Group::conclude(dying);
  const std::lock_guard members(context_.callbacks());
  dying.clear();
}

// Others learn of it with the endpoints (DDS 1.4, 2.2.3.2).
Status DomainParticipant::announce_again(const Topic& topic) {
  const std::lock_guard members(context_.callbacks());
  const auto each = [&](auto& groups) -> Status {
    for (auto& group : groups)
      for (auto& member : group->members_)
        if (&member->topic() == &topic) DDSSEC_TRY(member->regroup(group->qos()));
    return {};
  };
  DDSSEC_TRY(each(publishers_));
  return each(subscribers_);
}

bool DomainParticipant::contains_entities() const {
  const auto held = lock();
  return !topics_.empty() || !filtered_topics_.empty() || !publishers_.empty() ||
         !subscribers_.empty();
}

Status DomainParticipant::assert_liveliness() {
  const auto held = lock();
  DDSSEC_TRY(check_enabled("participant"));
  manual_liveliness_.assert_all(context_.now(), true);
  context_.reschedule();
  return {};
}

}  // namespace ddssec::rtps
