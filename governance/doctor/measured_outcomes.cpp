#include "governance/doctor/measured_outcomes.hpp"

#include <algorithm>

namespace ddssec::governance::doctor {
namespace {

using enum Outcome;

struct Column {
  Vendor vendor;
  KnownVersion known;
};

constexpr Column kColumns[] = {
#define COLUMN(vendor, major, minor, patch, source) \
  {Vendor::vendor, {{major, minor, patch}, Source::source}},
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

// The column of the version that represents `version`; the versions of a vendor are ascending.
std::size_t column_for(Vendor vendor, Version version) {
  std::size_t best = std::size(kColumns);
  for (std::size_t i = 0; i < std::size(kColumns); ++i)
    if (kColumns[i].vendor == vendor &&
        (best == std::size(kColumns) || kColumns[i].known.version <= version))
      best = i;
  return best;
}

}  // namespace

std::vector<KnownVersion> known_versions(Vendor vendor) {
  std::vector<KnownVersion> out;
  for (const auto& column : kColumns)
    if (column.vendor == vendor) out.push_back(column.known);
  return out;
}

KnownVersion stand_in(Vendor vendor, Version version) {
  return kColumns[column_for(vendor, version)].known;
}

Outcomes measured(Variant variant, const Lineup& lineup) {
  const auto& row = kRows[static_cast<std::size_t>(variant)];
  return {.cyclonedds = row[column_for(Vendor::cyclonedds, lineup.cyclonedds)],
          .fastdds = row[column_for(Vendor::fastdds, lineup.fastdds)]};
}

}  // namespace ddssec::governance::doctor
