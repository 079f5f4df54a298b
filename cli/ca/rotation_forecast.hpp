// Predicts which participants would no longer accept each other after a step of a rotation, for the
// dry run of `ca rotate`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca/ca_rotation.hpp"
#include "cli/frame/fields.hpp"

namespace ddssec::cli {

/// Two participants that accept each other's CA now, and would not after the step.
struct PartedPair {
  static constexpr std::string_view kDef = "parted_pair";
  std::string a, b;  ///< their folders
  bool only_stock;

  static constexpr auto fields() {
    using Self = PartedPair;
    return std::tuple(
        field<&Self::a>({.def = "path"}), field<&Self::b>({.def = "path"}),
        field<&Self::only_stock>({"true: only if one of the two runs on stock plugins, which use "
                                  "the first CA of a file alone"}));
  }
};

/// The forecast for all participants of a CA whose folders are on this machine.
struct RotationForecast {
  static constexpr std::string_view kDef = "rotation_forecast";
  std::size_t judged = 0;  ///< folders
  std::size_t parted = 0;  ///< pairs
  std::vector<PartedPair> pairs = {};
  std::vector<std::string> unread = {};
  bool needs_restarts = false;  ///< true if some participants may run on stock plugins

  static constexpr auto fields() {
    using Self = RotationForecast;
    return std::tuple(
        field<&Self::judged>({"folders"}),
        field<&Self::parted>(
            {"how many pairs that accept each other's CA now, and would not then"}),
        field<&Self::pairs>({.note = "the first 1000 of them", .max = 1000}),
        field<&Self::unread>({.note = "folders whose files say nothing", .def = "path"}));
  }
  std::string text() const;
};

/// A step that has been drafted.
struct ForecastStep {
  const std::string& role;
  const CaRotation& change;
  const std::vector<std::string>&
      updated_participants;  ///< the names of the participants that get new files
  WallTime now;
};

/// Compares the files in the folders with what the step makes of them. Only the CAs of this role
/// are judged, as the plugins read them; `ddssec check` judges the rest. All participants of the
/// step are judged, and all others that the log of the CA at `given` has on this machine, except
/// revoked ones. Errors: those of affected_participants and RotationProgress::of.
Result<RotationForecast> forecast_of(const ForecastStep& step, const std::filesystem::path& given,
                                     const std::vector<AffectedParticipant>& participants);

}  // namespace ddssec::cli
