// AnyDataWriter, the part that applies readers' content filters.
#include "rtps/dcps/data_writer.hpp"
#include "rtps/filter/bound_filter.hpp"

namespace ddssec::rtps {
namespace {

/// The expressions are those of remote readers. An honest one with a few comparisons takes some
/// tens; 32 filters that take all of it cost a write about 0.2 ms.
constexpr std::size_t kMostSteps = 2048;

class SqlFilter final : public ChangeFilter {
 public:
  SqlFilter(BoundFilter filter, const FilterSignature& of) : filter_(std::move(filter)) {
    signature = of;
  }
  // What cannot be read here, or costs too much, is the reader's to judge.
  std::optional<bool> passes(const Change& change) override {
    return filter_.passes_within(kMostSteps, change.payload.view());
  }

 private:
  BoundFilter filter_;
};

}  // namespace

// RTPS 2.5, 8.7.3.4: a filter that we cannot apply is no reason to refuse its reader. One of
// coherent sets must see that none of their changes is missing.
std::shared_ptr<ChangeFilter> AnyDataWriter::filter_for(const EndpointData& reader) {
  const auto& property = *reader.content_filter;
  const auto& view = topic_.type().view;
  if (!view || reader.qos.presentation.coherent_access || property.filter_class_name != kDdsSql ||
      property.related_topic_name != topic_.name())
    return nullptr;
  auto filter = BoundFilter::compile(property.filter, view());
  if (!filter) return nullptr;
  return std::make_shared<SqlFilter>(*std::move(filter), signature_of(property));
}

}  // namespace ddssec::rtps
