#include "cli/doctor/ocsp_checks.hpp"

#include <filesystem>

#include <fmt/format.h>

#include "base/uri_source.hpp"
#include "cli/ca/ocsp_response.hpp"
#include "cli/doctor/folder_configuration.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "plugins/spi/ocsp_policy.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
using doctor::LoadedFolder;
using doctor::Outcome;

fs::path response_file(const LoadedFolder& folder, const spi::PropertyList& properties) {
  const auto named = spi::property_value(properties, spi::property::kOcspResponse);
  return file_named_by(absolute_uri(named)).value_or(ocsp_file(folder.paths).string());
}

// The response in the file, judged with the CAs and revocation lists of `judge`. Errors:
// file_not_found; those of read_file and judge_ocsp, or of the parts of the folder that are needed.
Result<pki::GoodOcspStatus> response_of(const LoadedFolder& folder, const fs::path& file,
                                        const LoadedFolder& judge, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxOcspOctets));
  if (!folder.certificate) return std::unexpected(folder.certificate.error());
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, judge.chain());
  return pki::judge_ocsp(octets, *folder.certificate, verifier, now);
}

Finding response_finding(const fs::path& file, const Error& error) {
  return {.rule = Rule::DOC112,
          .message = fmt::format("{}: {}", file.filename().string(), error.message()),
          .document = file.string(),
          .hint = error.code() == Code::ocsp_revoked ? std::string(error.hint()) : std::string()};
}

bool demands(const doctor::Party& party) {
  if (party.product != doctor::Product::ddssec) return false;
  const auto policy = spi::ocsp_policy(readable_properties(party.folder.paths));
  return policy && *policy == spi::OcspPolicy::hard;
}

// The reason why the participant shows the judge no response that says "good"; empty if it shows
// one. A participant does not send a response that it does not itself accept as good.
std::string missing_response_reason(const doctor::Party& party, const LoadedFolder& judge,
                                    WallTime now) {
  if (party.product != doctor::Product::ddssec) return party.product_name() + " sends none";
  const auto file = response_file(party.folder, readable_properties(party.folder.paths));
  auto response = response_of(party.folder, file, party.folder, now);
  if (response) response = response_of(party.folder, file, judge, now);
  if (response) return {};
  if (response.error().code() == Code::file_not_found)
    return fmt::format("there is no {}", file.filename().string());
  return fmt::format("{}: {}", file.filename().string(), response.error().message());
}

}  // namespace

void diagnose_ocsp(const LoadedFolder& folder, const doctor::Settings& settings,
                   doctor::Diagnosis& out) {
  const auto properties = readable_properties(folder.paths);
  const auto file = response_file(folder, properties);
  const auto policy = spi::ocsp_policy(properties);
  const bool is_asked = spi::find_property(properties, spi::property::kOcsp) != nullptr ||
                        spi::find_property(properties, spi::property::kOcspResponse) != nullptr;
  if (!path_exists(file) && !is_asked) return;
  out.pass(Rule::DOC112);
  if (!policy)
    out.report({.ddssec = Outcome::fail}, {.rule = Rule::DOC112,
                                           .message = policy.error().to_sentence(),
                                           .document = folder.paths.properties.string(),
                                           .hint = std::string(policy.error().hint())});
  if (!path_exists(file) || !folder.certificate || !folder.chain()) return;
  const auto response = response_of(folder, file, folder, settings.now);
  if (response) return;
  auto finding = response_finding(file, response.error());
  if (response.error().code() == Code::ocsp_revoked)
    return out.report({.ddssec = Outcome::fail}, std::move(finding));
  // The participant starts without a response.
  finding.severity = Severity::warning;
  out.report({}, std::move(finding));
}

std::vector<Finding> demanded_responses(const doctor::Party& a, const doctor::Party& b,
                                        WallTime now) {
  std::vector<Finding> out;
  const doctor::Party* const parties[] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    const auto& judge = *parties[i];
    const auto& other = *parties[1 - i];
    if (!demands(judge)) continue;
    const auto reason = missing_response_reason(other, judge.folder, now);
    if (reason.empty()) continue;
    out.push_back({.rule = Rule::DOC113,
                   .message = fmt::format("{} demands an OCSP response ({} = hard), and {} has "
                                          "none that it can use: {}",
                                          judge.name, spi::property::kOcsp, other.name, reason),
                   .document = judge.folder.paths.properties.string()});
  }
  return out;
}

}  // namespace ddssec::cli
