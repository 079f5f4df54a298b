#include "rtps/dcps/content_filtered_topic.hpp"

#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

ContentFilteredTopic::ContentFilteredTopic(ParticipantContext& context, std::string name,
                                           Topic& related, FilterText text)
    : context_(context), name_(std::move(name)), related_(related), text_(std::move(text)) {
  const auto held = lock();
  ++related_.users_;
}

ContentFilteredTopic::~ContentFilteredTopic() {
  const auto held = lock();
  --related_.users_;
}

std::vector<std::string> ContentFilteredTopic::expression_parameters() const {
  const auto held = lock();
  return text_.parameters;
}

Result<BoundFilter> ContentFilteredTopic::compile(const FilterText& text) const {
  const auto& view = related_.type().view;
  return BoundFilter::compile(text, view ? view() : nullptr);
}

ContentFilterProperty ContentFilteredTopic::property() const {
  return {
      .content_filtered_topic_name = name_, .related_topic_name = related_.name(), .filter = text_};
}

Status ContentFilteredTopic::set_expression_parameters(std::vector<std::string> parameters) {
  const auto held = lock();
  FilterText text{text_.expression, std::move(parameters)};
  DDSSEC_TRY(compile(text));
  text_.parameters = std::move(text.parameters);
  for (auto* reader : readers_) {
    DDSSEC_TRY(reader->update());
    if (reader->reader())
      context_.protocol().change_filter(*reader->reader(), property(), context_.now());
  }
  context_.reschedule();
  return {};
}

Result<ContentFilteredTopic*> DomainParticipant::create_contentfilteredtopic(std::string name,
                                                                             Topic& related,
                                                                             FilterText filter) {
  if (&related.participant() != this)
    return precondition_not_met("topic " + related.name(), "one of the same participant",
                                "another's");
  DDSSEC_TRY(check_name(name));
  const std::lock_guard members(context_.callbacks());
  DDSSEC_TRY(check_new_name(name));
  std::unique_ptr<ContentFilteredTopic> topic(
      new ContentFilteredTopic(context_, std::move(name), related, std::move(filter)));
  DDSSEC_TRY(topic->compile(topic->text_));
  const auto held = lock();
  filtered_topics_.push_back(std::move(topic));
  return filtered_topics_.back().get();
}

Status DomainParticipant::delete_contentfilteredtopic(ContentFilteredTopic& topic) {
  const std::lock_guard members(context_.callbacks());
  bool unused = false;
  {
    const auto held = lock();
    unused = topic.readers_.empty();
  }
  return delete_child(filtered_topics_, topic, unused);
}

ContentFilteredTopic* DomainParticipant::lookup_contentfilteredtopic(std::string_view name) const {
  const auto held = lock();
  const auto at =
      std::ranges::find(filtered_topics_, name, [](const auto& t) { return t->name(); });
  return at == filtered_topics_.end() ? nullptr : at->get();
}

}  // namespace ddssec::rtps
