#include "cli/doctor/renewal_list_check.hpp"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <fmt/format.h>

#include "base/uri_source.hpp"
#include "cli/doctor/folder_configuration.hpp"
#include "cli/inputs/files.hpp"
#include "governance/read.hpp"
#include "pki/renewal_list.hpp"
#include "pki/smime_diagnosis.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
using doctor::LoadedFolder;

fs::path list_of(const LoadedFolder& folder) {
  const auto properties = readable_properties(folder.paths);
  const auto named = spi::property_value(properties, spi::property::kRenewalList);
  if (named.empty()) return folder.paths.renewals;
  return file_named_by(absolute_uri(named)).value_or(folder.paths.renewals.string());
}

// For each entry without effect: its subject and the reason.
using Reasons = std::vector<std::string>;

void look_at_certificates(const LoadedFolder& folder, const pki::RenewalList& list, WallTime now,
                          Reasons& out) {
  const auto verifier = folder.chain();
  if (!verifier) return;
  for (const auto& one : list.certificates) {
    const auto valid = verifier->verify(one, now);
    if (!valid && valid.error().code() != Code::certificate_not_yet_valid)
      out.push_back(fmt::format("{}: {}", one.subject(), valid.error().message()));
  }
}

// The reason why the document has no effect. Empty if one of its grants may count.
std::string reason_of(BytesView file, const pki::DocumentVerifier& verifier, WallTime now) {
  const auto form = pki::examine_document(file);
  const auto document = governance::read_permissions(form.unverified_text, form.first_line);
  const auto subject = document && !document->grants.empty() ? document->grants.front().subject_name
                                                             : std::string("permissions");
  if (const auto proof = verifier.verify(file, now); !proof)
    return fmt::format("{}: {}", subject, proof.error().message());
  if (!document) return fmt::format("{}: {}", subject, document.error().message());
  const bool may_count = std::ranges::any_of(document->grants, [&](const auto& grant) {
    return !grant.subject_is_expression && grant.validity.not_after > now;
  });
  return may_count ? std::string() : subject + ": no grant for a name that has not ended";
}

void look_at_permissions(const LoadedFolder& folder, const pki::RenewalList& list, WallTime now,
                         Reasons& out) {
  if (!folder.permissions_cas) return;
  const auto verifier = pki::DocumentVerifier::make(*folder.permissions_cas);
  if (!verifier) return;
  for (const auto& file : list.permissions)
    if (auto reason = reason_of(file, *verifier, now); !reason.empty())
      out.push_back(std::move(reason));
}

std::string to_text(const Reasons& reasons, std::size_t entries) {
  constexpr std::size_t kMax = 3;
  auto out = fmt::format("{} of {} entries {} no effect", reasons.size(), entries,
                         reasons.size() == 1 ? "has" : "have");
  for (std::size_t i = 0; i < std::min(kMax, reasons.size()); ++i)
    out += (i == 0 ? ": " : "; ") + reasons[i];
  if (reasons.size() > kMax) out += fmt::format("; and {} more", reasons.size() - kMax);
  return out;
}

}  // namespace

void diagnose_renewal_list(const LoadedFolder& folder, const doctor::Settings& settings,
                           doctor::Diagnosis& out) {
  const auto file = list_of(folder);
  if (!path_exists(file)) return;
  out.pass(Rule::DOC115);
  Finding finding{.rule = Rule::DOC115,
                  .message = {},
                  .document = file.string(),
                  .products = {doctor::id(doctor::Product::ddssec, settings.lineup)}};
  const auto list = [&]() -> Result<pki::RenewalList> {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxRenewalListOctets));
    return pki::RenewalList::parse(octets);
  }();
  if (!list) {
    finding.message = fmt::format("{}: {}", file.filename().string(), list.error().message());
    return out.report({}, std::move(finding));
  }
  Reasons reasons;
  look_at_certificates(folder, *list, settings.now, reasons);
  look_at_permissions(folder, *list, settings.now, reasons);
  if (reasons.empty()) return;
  const auto entries = list->certificates.size() + list->permissions.size();
  finding.message = fmt::format("{}: {}", file.filename().string(), to_text(reasons, entries));
  // It is normal that some entries expire.
  finding.severity = reasons.size() == entries ? Severity::warning : Severity::informational;
  out.report({}, std::move(finding));
}

}  // namespace ddssec::cli
