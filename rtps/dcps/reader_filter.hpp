// The ContentFilteredTopic of a DataReader, as applied by the reader (DDS 1.4, 2.2.2.3.3).
#pragma once

#include "rtps/discovery/content_filter_property.hpp"
#include "rtps/filter/bound_filter.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps {

class ContentFilteredTopic;

/// The filter of one reader. Without a topic, all samples pass. The caller holds the participant's
/// lock.
class ReaderFilter {
 public:
  ReaderFilter() = default;
  ReaderFilter(const ReaderFilter&) = delete;
  ReaderFilter& operator=(const ReaderFilter&) = delete;

  /// Applies the topic's filter from now on. The topic calls update() when its filter changes.
  /// Errors: rtps_filter_invalid.
  Status attach(ContentFilteredTopic& topic);
  /// Unregisters from the topic. Call it before destruction.
  void detach();
  /// Applies the topic's changed parameters. Errors: rtps_filter_invalid.
  Status update();

  /// Returns the topic; nullptr if all samples pass.
  ContentFilteredTopic* topic() const { return topic_; }
  BoundFilter* filter() { return filter_ ? &*filter_ : nullptr; }
  /// Returns the filter as discovery announces it.
  std::optional<ContentFilterProperty> property() const;
  /// Returns the reader's GUID, once it is enabled. From then on, changed parameters must also be
  /// announced.
  const std::optional<Guid>& reader() const { return reader_; }
  void announce_for(const Guid& reader) { reader_ = reader; }

 private:
  ContentFilteredTopic* topic_ = nullptr;
  std::optional<BoundFilter> filter_;
  std::optional<Guid> reader_;
};

}  // namespace ddssec::rtps
