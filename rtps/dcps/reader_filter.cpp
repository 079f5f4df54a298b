#include "rtps/dcps/reader_filter.hpp"

#include "rtps/dcps/content_filtered_topic.hpp"

namespace ddssec::rtps {

Status ReaderFilter::attach(ContentFilteredTopic& topic) {
  filter_.emplace(DDSSEC_TRY(topic.compile(topic.text_)));
  topic_ = &topic;
  topic.readers_.push_back(this);
  return {};
}

void ReaderFilter::detach() {
  if (topic_ != nullptr) std::erase(topic_->readers_, this);
}

Status ReaderFilter::update() {
  filter_.emplace(DDSSEC_TRY(topic_->compile(topic_->text_)));
  return {};
}

std::optional<ContentFilterProperty> ReaderFilter::property() const {
  if (topic_ == nullptr) return std::nullopt;
  return topic_->property();
}

}  // namespace ddssec::rtps
