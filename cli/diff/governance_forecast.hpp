// Predicts what running participants do with a changed governance document.
#pragma once

#include <string>

#include "cli/diff/diff_inputs.hpp"
#include "cli/frame/report.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// The outcome for each host: whether it accepts the new document while it runs.
struct GovernanceForecast {
  std::string_view ddssec, embedded, cyclonedds, stock;
  std::string reason;
  std::optional<std::string> at;
  std::string text = {};  ///< complete lines
  /// True if embedded participants change in two phases, provided that the revision allows it.
  bool is_phased = false;

  static constexpr auto fields() {
    using T = GovernanceForecast;
    constexpr FieldOptions kLive{.def = "live"};
    return std::tuple(field<&T::ddssec>({.note = "the worse of both", .def = "live"}),
                      field<&T::embedded>(kLive), field<&T::cyclonedds>(kLive),
                      field<&T::stock>({.words = "same|restart"}), field<&T::reason>(),
                      field<&T::at>());
  }
};

/// Predicts the outcomes. Considers every domain, without a tag and with each tag that a document
/// names. `is_same` is true if both documents have the same effect.
GovernanceForecast forecast_of(const governance::Governance& before,
                               const governance::Governance& after, const DiffSides& sides,
                               bool is_same);

}  // namespace ddssec::cli
