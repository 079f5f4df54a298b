#include "rtps/dcps/reader_filter.hpp"

#include <utility>

#include "rtps/dcps/content_filtered_topic.hpp"

namespace ddssec::rtps {

Status ReaderFilter::attach(ContentFilteredTopic& topic) {
  DDSSEC_ASSIGN_OR_RETURN(auto compiled, topic.compile(topic.text_));
  filter_.emplace(std::move(compiled));
  topic_ = &topic;
  topic.readers_.push_back(this);
  return {};
}

void ReaderFilter::detach() {
  if (topic_ != nullptr) std::erase(topic_->readers_, this);
}

Status ReaderFilter::update() {
  DDSSEC_ASSIGN_OR_RETURN(auto compiled, topic_->compile(topic_->text_));
  filter_.emplace(std::move(compiled));
  return {};
}

std::optional<ContentFilterProperty> ReaderFilter::property() const {
  if (topic_ == nullptr) return std::nullopt;
  return topic_->property();
}

}  // namespace ddssec::rtps
