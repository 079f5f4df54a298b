// The ContentFilteredTopic of a DataReader, as the reader applies it (DDS 1.4, 2.2.2.3.3).
#pragma once

#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/filter/bound_filter.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

class ContentFilteredTopic;

/// Empty at first: then everything passes. The caller holds the participant's lock.
class ReaderFilter {
 public:
  ReaderFilter() = default;
  ReaderFilter(const ReaderFilter&) = delete;
  ReaderFilter& operator=(const ReaderFilter&) = delete;

  /// What passes the topic's filter passes from now on; the topic says when it changes. Errors:
  /// rtps_filter_invalid.
  Status attach(ContentFilteredTopic& topic);
  /// Before it dies.
  void detach();
  /// The topic has other parameters. Errors: rtps_filter_invalid.
  Status update();

  /// nullptr: everything passes.
  ContentFilteredTopic* topic() const { return topic_; }
  BoundFilter* filter() { return filter_ ? &*filter_ : nullptr; }
  /// What discovery announces of it.
  std::optional<ContentFilterProperty> property() const;
  /// The reader, once it is enabled: then other parameters must be announced, too.
  const std::optional<Guid>& reader() const { return reader_; }
  void announce_for(const Guid& reader) { reader_ = reader; }

 private:
  ContentFilteredTopic* topic_ = nullptr;
  std::optional<BoundFilter> filter_;
  std::optional<Guid> reader_;
};

}  // namespace ddssec::rtps
