// ContentFilteredTopic of DDS 1.4, 2.2.2.3.3.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "rtps/dcps/topic.hpp"
#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/filter/bound_filter.hpp"

namespace ddssec::rtps {

class ReaderFilter;

/// A topic whose readers receive only the samples that pass a filter. Created and deleted by its
/// participant. Thread-safe.
class ContentFilteredTopic {
 public:
  ~ContentFilteredTopic();
  ContentFilteredTopic(const ContentFilteredTopic&) = delete;
  ContentFilteredTopic& operator=(const ContentFilteredTopic&) = delete;

  const std::string& name() const { return name_; }
  Topic& related_topic() const { return related_; }
  const std::string& filter_expression() const { return text_.expression; }
  /// Returns the values of %0, %1 and so on in the expression.
  std::vector<std::string> expression_parameters() const;
  /// Sets the values of the parameters. They apply to all its readers, from the next sample on.
  /// Errors: rtps_filter_invalid; then nothing has changed.
  Status set_expression_parameters(std::vector<std::string> parameters);

 private:
  friend class ReaderFilter;
  friend class TopicDescriptions;
  ContentFilteredTopic(ParticipantContext& context, std::string name, Topic& related,
                       FilterText text);

  Result<BoundFilter> compile(const FilterText& text) const;
  ContentFilterProperty property() const;
  std::unique_lock<std::mutex> lock() const { return std::unique_lock(context_.mutex()); }

  ParticipantContext& context_;
  const std::string name_;
  Topic& related_;
  FilterText text_;
  std::vector<ReaderFilter*> readers_;
};

}  // namespace ddssec::rtps
