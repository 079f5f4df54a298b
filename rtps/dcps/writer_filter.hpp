// Readers' content filters, applied by the writer (RTPS 2.5, 8.7.3).
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/filter/bound_filter.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/change_filter.hpp"

namespace ddssec::rtps {

/// The filter that one matched reader announced. If the writer cannot deserialize a sample, or
/// cannot evaluate the filter within kMaxSteps, the reader decides.
class WriterFilter final : public ChangeFilter {
 public:
  /// Limits the cost of expressions, which come from remote readers. An honest expression with a
  /// few comparisons takes some tens of steps. 32 filters that use all steps cost a write about 0.2
  /// ms.
  static constexpr std::size_t kMaxSteps = 2048;

  /// Creates the filter that decides which samples on that topic need not be sent to `reader`,
  /// which announced it. `view` is a view of samples of the topic's type, and may be nullptr.
  /// Returns nullptr if the reader gets all samples:
  /// - if the writer cannot apply the filter, which is no reason to refuse the reader (8.7.3.4);
  /// - if the reader reads coherent sets, because it must see that none of their changes is
  ///   missing.
  static std::shared_ptr<ChangeFilter> of(const EndpointData& reader, std::string_view topic_name,
                                          std::unique_ptr<SampleView> view);

  WriterFilter(BoundFilter filter, const FilterSignature& filter_signature);
  std::optional<bool> passes(const Change& change) override;

 private:
  BoundFilter filter_;
};

}  // namespace ddssec::rtps
