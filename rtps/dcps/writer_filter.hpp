// Content filters of readers, applied by the writer (RTPS 2.5, 8.7.3).
#pragma once

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/filter/bound_filter.hpp"
#include "rtps/reliability/change.hpp"
#include "rtps/reliability/change_filter.hpp"

namespace ddssec::rtps {

/// The filter that one matched reader announced. What it cannot read, or not within kMaxSteps, is
/// the reader's to judge.
class WriterFilter final : public ChangeFilter {
 public:
  /// The expressions are those of remote readers. An honest one with a few comparisons takes some
  /// tens of steps; 32 filters that take all of it cost a write about 0.2 ms.
  static constexpr std::size_t kMaxSteps = 2048;

  /// What `reader`, which announced a filter, need not be sent of that topic. nullptr if it gets
  /// everything: a filter that we cannot apply is no reason to refuse its reader (8.7.3.4), and a
  /// reader of coherent sets must see that none of their changes is missing. `view`: of samples of
  /// the topic's type, may be nullptr.
  static std::shared_ptr<ChangeFilter> of(const EndpointData& reader, std::string_view topic_name,
                                          std::unique_ptr<SampleView> view);

  WriterFilter(BoundFilter filter, const FilterSignature& of);
  std::optional<bool> passes(const Change& change) override;

 private:
  BoundFilter filter_;
};

}  // namespace ddssec::rtps
