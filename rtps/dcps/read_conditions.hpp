// The ReadConditions and QueryConditions of a DataReader (DDS 1.4, 2.2.2.5.8 and 2.2.2.5.9).
#pragma once

#include "rtps/dcps/condition.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

/// Creates and deletes the conditions of one reader. The caller holds the participant's lock.
class ReadConditions {
 public:
  /// `reader` and `type`, the type of its samples, must outlive this object.
  ReadConditions(AnyDataReader& reader, const TypeSupport& type) : reader_(reader), type_(type) {}

  ReadCondition& create(const States& states);
  /// Creates a QueryCondition. The samples must be matched afterwards (QueryMatches::match).
  /// Errors: rtps_filter_invalid.
  Result<QueryCondition*> create(const States& states, FilterText query);
  /// Returns nullptr for an empty expression, which finds everything. Errors: rtps_filter_invalid.
  Result<std::unique_ptr<BoundFilter>> compile(const FilterText& query) const;
  /// Deletes the condition. Errors: rtps_precondition_not_met (it belongs to another reader).
  Status erase(const ReadCondition& condition);
  void clear();
  std::size_t size() const { return conditions_.size(); }
  /// Returns the queries of the QueryConditions. HeldInstances keeps them up to date.
  const Queries& queries() const { return queries_; }

  /// Triggers the conditions that find a sample in the cache.
  void update(const ReaderCache& cache);

 private:
  AnyDataReader& reader_;
  const TypeSupport& type_;
  Queries queries_;
  std::vector<std::unique_ptr<ReadCondition>> conditions_;
};

}  // namespace ddssec::rtps
