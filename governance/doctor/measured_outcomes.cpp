#include "governance/doctor/measured_outcomes.hpp"

namespace ddssec::governance::doctor {
namespace {

using enum Outcome;

struct Column {
  Product product;
  KnownVersion known;
};

constexpr Column kColumns[] = {
#define COLUMN(product, major, minor, patch, source) \
  {Product::product, {{major, minor, patch}, Source::source}},
#define ROW(...)
#include "governance/doctor/measured_outcomes.def"
#undef ROW
#undef COLUMN
};

constexpr Outcome kRows[][std::size(kColumns)] = {
#define COLUMN(...)
#define ROW(name, ...) {__VA_ARGS__},
#include "governance/doctor/measured_outcomes.def"
#undef ROW
#undef COLUMN
};

// The column of the version that represents `version`; the versions of a product are ascending.
std::size_t column_for(Product product, Version version) {
  std::size_t best = std::size(kColumns);
  for (std::size_t i = 0; i < std::size(kColumns); ++i)
    if (kColumns[i].product == product &&
        (best == std::size(kColumns) || kColumns[i].known.version <= version))
      best = i;
  return best;
}

}  // namespace

std::vector<KnownVersion> known_versions(Product product) {
  std::vector<KnownVersion> out;
  for (const auto& column : kColumns)
    if (column.product == product) out.push_back(column.known);
  return out;
}

KnownVersion stand_in(Product product, Version version) {
  return kColumns[column_for(product, version)].known;
}

Outcomes measured(Variant variant, const Lineup& lineup) {
  const auto& row = kRows[static_cast<std::size_t>(variant)];
  return {.cyclonedds = row[column_for(Product::cyclonedds, lineup.cyclonedds)],
          .fastdds = row[column_for(Product::fastdds, lineup.fastdds)]};
}

}  // namespace ddssec::governance::doctor
