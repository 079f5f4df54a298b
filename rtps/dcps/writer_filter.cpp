#include "rtps/dcps/writer_filter.hpp"

namespace ddssec::rtps {

std::shared_ptr<ChangeFilter> WriterFilter::of(const EndpointData& reader,
                                               std::string_view topic_name,
                                               std::unique_ptr<SampleView> view) {
  const auto& property = *reader.content_filter;
  if (!view || reader.qos.presentation.coherent_access || property.filter_class_name != kDdsSql ||
      property.related_topic_name != topic_name)
    return nullptr;
  auto filter = BoundFilter::compile(property.filter, std::move(view));
  if (!filter) return nullptr;
  return std::make_shared<WriterFilter>(*std::move(filter), signature_of(property));
}

WriterFilter::WriterFilter(BoundFilter filter, const FilterSignature& filter_signature)
    : filter_(std::move(filter)) {
  signature = filter_signature;
}

std::optional<bool> WriterFilter::passes(const Change& change) {
  return filter_.passes_within(kMaxSteps, change.payload.view());
}

}  // namespace ddssec::rtps
