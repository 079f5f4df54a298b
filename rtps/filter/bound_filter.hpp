// A filter together with the view through which it accesses samples.
#pragma once

#include "rtps/filter/filter.hpp"

namespace ddssec::rtps {

/// A compiled filter and its view. Not thread-safe: it decodes into its own memory.
class BoundFilter {
 public:
  /// Compiles the filter. If `view` is nullptr, the type has no named members. Errors:
  /// rtps_filter_invalid.
  static Result<BoundFilter> compile(const FilterText& text, std::unique_ptr<SampleView> view) {
    static const std::span<const Leaf> kNone;
    auto filter = Filter::compile(text, view ? view->leaves() : kNone);
    if (!filter) return std::unexpected(filter.error());
    return BoundFilter(*std::move(filter), std::move(view));
  }

  /// Returns whether a serialized sample passes. Errors: those of deserialize.
  Result<bool> passes(BytesView payload) {
    if (auto read = view_->decode(payload, filter_.members()); !read)
      return std::unexpected(read.error());
    return filter_.passes(*view_);
  }
  /// As passes, with at most this many steps (Filter::passes_within). Empty if the sample cannot be
  /// read, or needs more steps.
  std::optional<bool> passes_within(std::size_t max_steps, BytesView payload) {
    if (!view_->decode(payload, filter_.members())) return std::nullopt;
    return filter_.passes_within(max_steps, *view_);
  }

 private:
  BoundFilter(Filter filter, std::unique_ptr<SampleView> view)
      : filter_(std::move(filter)), view_(std::move(view)) {}

  Filter filter_;
  std::unique_ptr<SampleView> view_;  // never null: without leaves no expression compiles
};

}  // namespace ddssec::rtps
