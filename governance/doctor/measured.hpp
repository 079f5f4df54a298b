// What each version of a product was measured to do (measured.def).
#pragma once

#include <vector>

#include "governance/doctor/vendor.hpp"

namespace ddssec::governance::doctor {

/// The folders of tests/cli/golden_folders.py that the products were started on. Each stands for
/// what is special about it.
enum class Variant : std::uint8_t {
#define COLUMN(vendor, major, minor, patch, source)
#define ROW(name, ...) name,
#include "governance/doctor/measured.def"
#undef ROW
#undef COLUMN
};

/// How it is known what a version does.
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

/// The versions of the table, rising. Empty for ours.
std::vector<KnownVersion> known_versions(Vendor vendor);

/// The version of the table that stands for `version` of a stock product: the newest that is not
/// newer, or the oldest of all.
KnownVersion stand_in(Vendor vendor, Version version);

/// What the versions that stand for the lineup's make of the variant; of ours it says ok.
Outcomes measured(Variant variant, const Lineup& lineup);

}  // namespace ddssec::governance::doctor
