#include "cli/ca/rotation_forecast.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/affected_participants.hpp"
#include "cli/ca/ca_progress.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/host_plugins.hpp"
#include "pki/key_digests.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

constexpr std::size_t kMaxPairs = 1000;

// Identifies a CA by its name and key, because its certificate may have been renewed.
std::string id_of(const pki::Certificate& ca) { return pki::key_digest(ca) + ca.subject(); }

std::vector<std::string> ids_of(const std::vector<pki::Certificate>& cas) {
  std::vector<std::string> out;
  for (const auto& ca : cas) out.push_back(id_of(ca));
  return out;
}

// The CA of a participant's own documents, and the CAs that it accepts.
struct TrustState {
  std::string own;                   // the CA of its certificate or its permissions
  std::vector<std::string> trusted;  // in the order of its file
};

// True if `one` accepts the CA of `other`.
bool accepts(const TrustState& one, const TrustState& other, bool is_stock) {
  if (is_stock) return !one.trusted.empty() && one.trusted.front() == other.own;
  return std::ranges::find(one.trusted, other.own) != one.trusted.end();
}

struct ForecastParticipant {
  std::string name;
  TrustState before, after;
  bool may_be_stock;
};

bool accept_each_other(const TrustState& a, const TrustState& b, bool a_is_stock, bool b_is_stock) {
  return accepts(a, b, a_is_stock) && accepts(b, a, b_is_stock);
}

bool are_separated(const ForecastParticipant& a, const ForecastParticipant& b, bool a_is_stock,
                   bool b_is_stock) {
  return accept_each_other(a.before, b.before, a_is_stock, b_is_stock) &&
         !accept_each_other(a.after, b.after, a_is_stock, b_is_stock);
}

bool are_separated_if_stock(const ForecastParticipant& a, const ForecastParticipant& b) {
  return (a.may_be_stock && are_separated(a, b, true, false)) ||
         (b.may_be_stock && are_separated(a, b, false, true)) ||
         (a.may_be_stock && b.may_be_stock && are_separated(a, b, true, true));
}

// False if the folder's Cyclone DDS configuration names ddssec's libraries by absolute paths.
// Otherwise the environment of the process decides.
bool may_be_stock(const fs::path& folder) {
  const auto file = folder / "cyclonedds.xml";
  if (!path_exists(file)) return true;
  const auto configuration = doctor::cyclonedds_configuration(file.string());
  if (!configuration) return true;
  const auto plugins = doctor::host_plugins(*configuration, {});
  return plugins.empty() || !std::ranges::all_of(plugins, [](const doctor::HostPlugin& plugin) {
           return plugin.product == doctor::HostPlugin::PluginProduct::ddssec &&
                  fs::path(plugin.library).is_absolute();
         });
}

// Reads the CAs of a participant before and after the step.
class ForecastReader {
 public:
  explicit ForecastReader(const ForecastStep& step) : step_(step) {
    if (auto next = pki::Certificate::bundle_from_pem(as_bytes(step.change.trust_pem)))
      next_ = *std::move(next);
  }

  std::optional<ForecastParticipant> of(const AffectedParticipant& participant) const {
    const auto& file =
        is_identity() ? participant.files.identity_ca : participant.files.permissions_ca;
    const auto trusted = read_certificates(file);
    if (!trusted) return std::nullopt;
    const auto own = issuer_of(participant, *trusted);
    if (!own) return std::nullopt;
    TrustState before{*own, ids_of(*trusted)};
    auto after = before;
    std::error_code ignored;
    if (std::ranges::find(step_.updated_participants, participant.name) !=
        step_.updated_participants.end()) {
      if (!fs::is_symlink(file, ignored)) after.trusted = ids_of(next_);
      if (step_.change.step != RotationStep::begin)
        after.own = id_of(step_.change.ca.certificate());
    }
    return ForecastParticipant{participant.name, std::move(before), std::move(after),
                               may_be_stock(participant.files.folder)};
  }

 private:
  bool is_identity() const { return step_.role == "identity"; }

  bool is_issuer(const AffectedParticipant& participant, const pki::Certificate& ca) const {
    if (!is_identity()) return is_signed_by(participant.files.permissions, ca.pem(), step_.now);
    const auto certificate = read_certificate(participant.files.certificate);
    return certificate && certificate->is_issued_by(ca);
  }

  std::optional<std::string> issuer_of(const AffectedParticipant& participant,
                                       std::vector<pki::Certificate> cas) const {
    cas.insert(cas.end(), next_.begin(), next_.end());
    for (const auto& ca : cas)
      if (is_issuer(participant, ca)) return id_of(ca);
    return std::nullopt;
  }

  const ForecastStep& step_;
  std::vector<pki::Certificate> next_;
};

std::string line_of(const PartedPair& pair) {
  return fmt::format("  {} - {}{}\n", printable(pair.a), printable(pair.b),
                     pair.only_stock ? "  (if one of them runs on stock plugins)" : "");
}

}  // namespace

std::string RotationForecast::text() const {
  auto out = parted == 0 ? fmt::format("no two of {} would part by their CAs\n",
                                       count_text(judged, "folder"))
                         : fmt::format("{} of {} would part:\n", count_text(parted, "pair"),
                                       count_text(judged, "folder"));
  for (const auto& pair : pairs) out += line_of(pair);
  if (parted > pairs.size()) out += fmt::format("  and {} more\n", parted - pairs.size());
  for (const auto& folder : unread)
    out += fmt::format("not judged, its files say nothing: {}\n", printable(folder));
  if (needs_restarts)
    out += "A participant on stock plugins uses the new files once it was started again.\n";
  return out;
}

namespace {

// Adds the participants that the step leaves as they are, and removes revoked ones, which talk to
// no peer.
Result<std::vector<AffectedParticipant>> all_here(const fs::path& given,
                                                  std::vector<AffectedParticipant> participants,
                                                  WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto known, affected_participants(given, now));
  for (const auto& other : known.here) {
    const auto is_it = [&](const AffectedParticipant& one) {
      std::error_code ignored;
      return fs::equivalent(one.files.folder, other.files.folder, ignored);
    };
    if (std::ranges::none_of(participants, is_it)) participants.push_back(other);
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto progress, RotationProgress::of(given, "identity", now));
  for (const auto& revoked : progress.revoked(participants))
    std::erase_if(participants,
                  [&](const AffectedParticipant& one) { return one.name == revoked.name; });
  return participants;
}

}  // namespace

Result<RotationForecast> forecast_of(const ForecastStep& step, const fs::path& given,
                                     const std::vector<AffectedParticipant>& participants) {
  DDSSEC_ASSIGN_OR_RETURN(const auto all, all_here(given, participants, step.now));
  const ForecastReader reader(step);
  std::vector<ForecastParticipant> sides;
  RotationForecast out;
  // Each participant is read, and then compared with the others.
  Progress progress("steps of the forecast", 2 * all.size());
  for (const auto& participant : all) {
    progress.step();
    auto side = reader.of(participant);
    if (side)
      sides.push_back(*std::move(side));
    else
      out.unread.push_back(participant.name);
  }
  out.judged = sides.size();
  out.needs_restarts = step.change.step != RotationStep::begin &&
                       std::ranges::any_of(sides, [](const auto& one) { return one.may_be_stock; });
  for (auto a = sides.begin(); a != sides.end(); ++a) {
    progress.step();
    for (auto b = a + 1; b != sides.end(); ++b) {
      const bool is_for_all = are_separated(*a, *b, false, false);
      if (!is_for_all && !are_separated_if_stock(*a, *b)) continue;
      ++out.parted;
      if (out.pairs.size() < kMaxPairs) out.pairs.push_back({a->name, b->name, !is_for_all});
    }
  }
  return out;
}

}  // namespace ddssec::cli
