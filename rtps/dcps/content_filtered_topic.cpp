#include "rtps/dcps/content_filtered_topic.hpp"

#include "rtps/dcps/domain_participant.hpp"
#include "rtps/participant/rtps_participant.hpp"

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
  DDSSEC_RETURN_IF_ERROR(compile(text));
  text_.parameters = std::move(text.parameters);
  for (auto* reader : readers_) {
    DDSSEC_RETURN_IF_ERROR(reader->update());
    if (reader->reader())
      context_.protocol().change_filter(*reader->reader(), property(), context_.now());
  }
  context_.reschedule();
  return {};
}

}  // namespace ddssec::rtps
