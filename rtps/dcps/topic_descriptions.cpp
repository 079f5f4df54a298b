#include "rtps/dcps/topic_descriptions.hpp"

#include <fmt/format.h>

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/dcps/no_callbacks.hpp"
#include "rtps/participant/rtps_participant.hpp"

namespace ddssec::rtps {

Status TopicDescriptions::check_name(std::string_view name) {
  if (!name.empty() && name.size() <= kMaxNameLength) return {};
  return fail(Code::rtps_bad_parameter, {.document = "topic " + std::string(name),
                                         .field = "name of topic or type",
                                         .expected = "1 to 256 characters",
                                         .found = std::to_string(name.size())});
}

Status TopicDescriptions::check_new_name(std::string_view name) const {
  const bool is_topic = lookup(name) != nullptr;
  if (!is_topic && lookup_filtered(name) == nullptr) return {};
  return fail(Code::rtps_precondition_not_met,
              {.document = fmt::format("topic {}", name),
               .expected = "a new name",
               .found = is_topic ? "that of a topic" : "that of a content-filtered topic",
               .hint = fmt::format(
                   "{}(\"{}\") returns the one that has the name; or choose another",
                   is_topic ? "lookup_topicdescription" : "lookup_contentfilteredtopic", name)});
}

Result<Topic*> TopicDescriptions::create(std::string name, TypeSupport type, const Qos& qos,
                                         TopicListener* listener, StatusMask mask) {
  DDSSEC_RETURN_IF_ERROR(check_name(name));
  DDSSEC_RETURN_IF_ERROR(check_name(type.name));
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos));
  const std::lock_guard members(context_.members());
  DDSSEC_RETURN_IF_ERROR(check_new_name(name));
  if (!announce_types_) type.description = {};
  std::unique_ptr<Topic> topic(
      new Topic(participant_, context_, std::move(name), std::move(type), qos));
  topic->set_listener(listener, mask);
  if (participant_.is_enabled() && participant_.qos().autoenable_created_entities)
    DDSSEC_RETURN_IF_ERROR(topic->enable());
  auto* out = topics_.add(std::move(topic));
  const std::lock_guard held(context_.mutex());
  context_.notify();  // another thread may be waiting for this topic
  return out;
}

Result<ContentFilteredTopic*> TopicDescriptions::create_filtered(std::string name, Topic& related,
                                                                 FilterText filter) {
  if (&related.participant() != &participant_)
    return precondition_not_met_error("topic " + related.name(), "one of the same participant",
                                      "another's");
  DDSSEC_RETURN_IF_ERROR(check_name(name));
  const std::lock_guard members(context_.members());
  DDSSEC_RETURN_IF_ERROR(check_new_name(name));
  std::unique_ptr<ContentFilteredTopic> topic(
      new ContentFilteredTopic(context_, std::move(name), related, std::move(filter)));
  DDSSEC_RETURN_IF_ERROR(topic->compile(topic->text_));
  return filtered_.add(std::move(topic));
}

Topic* TopicDescriptions::lookup(std::string_view name) const {
  const std::lock_guard held(context_.mutex());
  return topics_.named(name);
}

ContentFilteredTopic* TopicDescriptions::lookup_filtered(std::string_view name) const {
  const std::lock_guard held(context_.mutex());
  return filtered_.named(name);
}

// Returns a topic of this participant, or creates a topic of octets with the type that remote
// endpoints use (DDS 1.4, 2.2.2.2.1.11).
Result<Topic*> TopicDescriptions::find(const std::string& name, std::chrono::nanoseconds timeout) {
  std::optional<EndpointData> remote;
  {
    std::unique_lock held(context_.mutex());
    Topic* own = nullptr;
    const bool found = context_.wait(held, timeout, [&] {
      own = topics_.named(name);
      remote = context_.protocol().endpoint_on(name);
      return own != nullptr || remote;
    });
    if (!found) return fail(Code::rtps_timeout, {.document = "topic " + name});
    if (own != nullptr) {
      ++own->references_;
      return own;
    }
  }
  return create(name, {.name = remote->type_name, .with_key = has_key(remote->guid.entity)},
                participant_.default_topic_qos(), nullptr, kAnyStatus);
}

// Returns true if the topic has other references, because it was found as well. It is deleted with
// its last reference.
bool TopicDescriptions::drop_reference(Topic& topic, bool& unused) const {
  const std::lock_guard held(context_.mutex());
  unused = topic.users_ == 0;
  if (!unused || topic.references_ <= 1) return false;
  --topic.references_;
  return true;
}

Status TopicDescriptions::remove(Topic& topic) {
  bool unused = false;
  if (drop_reference(topic, unused)) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  const std::lock_guard members(context_.members());
  if (drop_reference(topic, unused)) return {};
  return topics_.remove(topic, unused);
}

Status TopicDescriptions::remove(ContentFilteredTopic& topic) {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  const std::lock_guard members(context_.members());
  bool unused = false;
  {
    const std::lock_guard held(context_.mutex());
    unused = topic.readers_.empty();
  }
  return filtered_.remove(topic, unused);
}

Status TopicDescriptions::enable() {
  for (const auto& topic : topics_.all()) DDSSEC_RETURN_IF_ERROR(topic->enable());
  return {};
}

}  // namespace ddssec::rtps
