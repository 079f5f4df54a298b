#include "rtps/dcps/read_conditions.hpp"

#include <algorithm>

#include "rtps/dcps/data_reader.hpp"

namespace ddssec::rtps {

ReadCondition& ReadConditions::create(const States& states) {
  conditions_.emplace_back(new ReadCondition(reader_, states));
  return *conditions_.back();
}

Result<QueryCondition*> ReadConditions::create(const States& states, FilterText query) {
  DDSSEC_ASSIGN_OR_RETURN(auto compiled, compile(query));
  auto matches = compiled ? std::make_unique<QueryMatches>(std::move(*compiled)) : nullptr;
  queries_.reserve(queries_.size() + 1);
  std::unique_ptr<QueryCondition> condition(
      new QueryCondition(reader_, states, std::move(query), std::move(matches)));
  auto* out = condition.get();
  conditions_.push_back(std::move(condition));
  if (out->query_) queries_.push_back(out->query_.get());
  return out;
}

Result<std::unique_ptr<BoundFilter>> ReadConditions::compile(const FilterText& query) const {
  if (query.expression.find_first_not_of(" \t\r\n") == std::string::npos) return nullptr;
  DDSSEC_ASSIGN_OR_RETURN(auto bound_filter,
                          BoundFilter::compile(query, type_.view ? type_.view() : nullptr));
  return std::make_unique<BoundFilter>(std::move(bound_filter));
}

Status ReadConditions::erase(const ReadCondition& condition) {
  const auto at = std::ranges::find(conditions_, &condition, &std::unique_ptr<ReadCondition>::get);
  if (at == conditions_.end())
    return precondition_not_met_error("read condition", "one of this reader", "another's");
  std::erase(queries_, condition.query());
  conditions_.erase(at);
  return {};
}

void ReadConditions::clear() {
  queries_.clear();
  conditions_.clear();
}

void ReadConditions::update(const ReaderCache& cache) {
  for (auto& condition : conditions_)
    condition->trigger(cache.any(condition->states(), condition->query()));
}

}  // namespace ddssec::rtps
