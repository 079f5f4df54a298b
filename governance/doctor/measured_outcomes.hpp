// The measured behaviour of each version of a product (measured_outcomes.def).
#pragma once

#include <vector>

#include "governance/doctor/product.hpp"

namespace ddssec::governance::doctor {

/// The folders of tests/cli/golden_folders.py with which the products were started. Each is named
/// after its special feature.
enum class Variant : std::uint8_t {
#define COLUMN(product, major, minor, patch, source)
#define ROW(name, ...) name,
#include "governance/doctor/measured_outcomes.def"
#undef ROW
#undef COLUMN
};

/// The source of knowledge about a version.
enum class Source : std::uint8_t {
  measured,  ///< tests/interop/measure.py started the product
  reported,  ///< taken from a review of that version
};

/// A version of the table.
struct KnownVersion {
  Version version;
  Source source = Source::measured;
  bool operator==(const KnownVersion&) const = default;
};

/// Whether wrong dates count, or are ok because another check reports them.
enum class WrongDates : std::uint8_t { count, reported_elsewhere };

/// Returns the versions of the table, ascending. Empty for ddssec.
std::vector<KnownVersion> known_versions(Product product);

/// Returns the version of the table that represents `version` of a stock product: the newest that
/// is not newer, or the oldest of all.
KnownVersion stand_in(Product product, Version version);

/// Returns the outcomes for the variant with the versions that represent the lineup; ok for ddssec.
Outcomes measured(Variant variant, const Lineup& lineup);

}  // namespace ddssec::governance::doctor
