#include "cli/ca/ca_overlap.hpp"

#include <algorithm>

#include "base/tool_code.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/report.hpp"
#include "cli/inputs/files.hpp"
#include "governance/date_time.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

bool holds(const std::vector<pki::Certificate>& certificates, const pki::Certificate& one) {
  return std::ranges::find(certificates, one) != certificates.end();
}

fs::path beside(const CaPaths& ca, std::string_view ending) {
  return ca.certificate.parent_path() / (ca.certificate.stem().string() + std::string(ending));
}

std::unexpected<Error> unreadable_overlap_error(const fs::path& file) {
  return fail(tool_code::overlap_unreadable, {.document = file});
}

}  // namespace

CaOverlap overlap_of(std::vector<pki::Certificate> next,
                     const std::vector<pki::Certificate>& former, WallTime until) {
  CaOverlap out{std::move(next), {}, until};
  std::ranges::copy_if(former, std::back_inserter(out.former),
                       [&](const auto& ca) { return !holds(out.next, ca); });
  return out;
}

fs::path overlap_file(const CaPaths& ca) { return beside(ca, ".overlap.json"); }

std::string overlap_text(const CaOverlap& overlap) {
  Json former = Json::array();
  for (const auto& ca : overlap.former) former.push_back(to_hex(ca.fingerprint()));
  return Json{{"until", to_string(overlap.until)}, {"former", former}}.dump(2) + "\n";
}

Result<std::optional<CaOverlap>> read_overlap(const CaPaths& ca) {
  const auto file = overlap_file(ca);
  if (!path_exists(file)) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(const auto text, read_file(file, pki::kMaxBundleOctets));
  const auto json = Json::parse(as_text(text), nullptr, false);
  if (!json.is_object() || !json.contains("until") || !json.contains("former") ||
      !json["until"].is_string() || !json["former"].is_array())
    return unreadable_overlap_error(file);
  const auto until =
      governance::parse_date_time(json["until"].get<std::string>(), governance::Round::down);
  if (!until) return unreadable_overlap_error(file);
  CaOverlap out{{}, {}, until->time};
  DDSSEC_ASSIGN_OR_RETURN(auto certificates, read_certificates(ca.certificate));
  for (auto& certificate : certificates) {
    const bool is_former =
        std::ranges::find(json["former"], Json(to_hex(certificate.fingerprint()))) !=
        json["former"].end();
    (is_former ? out.former : out.next).push_back(std::move(certificate));
  }
  if (out.former.empty()) return std::nullopt;  // the CA was replaced at once in the meantime
  if (out.next.empty()) return unreadable_overlap_error(file);
  return out;
}

fs::path unreached_file(const CaPaths& ca) { return beside(ca, ".unreached.json"); }

std::string unreached_text(const std::vector<std::string>& folders) {
  return Json{{"folders", folders}}.dump(2) + "\n";
}

std::vector<std::string> read_unreached(const CaPaths& ca) {
  std::vector<std::string> out;
  const auto file = unreached_file(ca);
  const auto text = path_exists(file) ? read_file(file, pki::kMaxDocumentOctets) : Bytes();
  const auto json = text ? Json::parse(as_text(*text), nullptr, false) : Json();
  if (!json.is_object() || !json.contains("folders") || !json["folders"].is_array()) return out;
  for (const auto& folder : json["folders"])
    if (folder.is_string()) out.push_back(folder.get<std::string>());
  return out;
}

Result<std::vector<pki::Crl>> lists_of_former(const CaPaths& ca, const CaOverlap& overlap) {
  DDSSEC_ASSIGN_OR_RETURN(auto lists, read_crls(ca.crl));
  std::erase_if(lists, [&](const pki::Crl& list) {
    return std::ranges::none_of(overlap.former,
                                [&](const auto& one) { return list.is_signed_by(one); });
  });
  return lists;
}

Result<std::string> file_of_lists(const CaPaths& ca, const pki::Crl& next) {
  auto text = next.pem();
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(ca));
  if (!overlap) return text;
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, lists_of_former(ca, *overlap));
  for (const auto& list : lists) text += list.pem();
  return text;
}

Status check_moved(const CaPaths& ca, const fs::path& document, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(ca));
  if (!overlap || is_signed_by(document, overlap->next_only(), now)) return {};
  return fail(tool_code::not_moved_yet, {.document = document});
}

Status check_moved(const CaPaths& ca, const pki::Certificate& signer, const fs::path& document) {
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(ca));
  if (!overlap) return {};
  const bool is_of_successor = std::ranges::any_of(
      overlap->next, [&](const auto& one) { return one == signer || signer.is_issued_by(one); });
  if (is_of_successor) return {};
  return fail(tool_code::not_moved_yet, {.document = document});
}

}  // namespace ddssec::cli
