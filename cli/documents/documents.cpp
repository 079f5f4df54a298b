#include "cli/documents/documents.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

#include "cli/frame/file_transaction.hpp"
#include "cli/inputs/files.hpp"
#include "governance/lint.hpp"
#include "pki/certificate_source.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Reads "3" or "0-5". Empty for any other text.
std::optional<governance::DomainRange> range_from(std::string_view text) {
  governance::DomainRange range;
  const auto* const end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, range.first);
  range.last = range.first;
  if (error == std::errc() && at != end && *at == '-') {
    const auto last = std::from_chars(at + 1, end, range.last);
    at = last.ptr;
    error = last.ec;
  }
  const bool is_whole = error == std::errc() && at == end;
  const bool is_sound = 0 <= range.first && range.first <= range.last &&
                        range.last <= governance::kMaxGovernedDomainId;
  return is_whole && is_sound ? std::optional(range) : std::nullopt;
}

Error with_replace_hint(const Error& error) {
  if (error.code() != Code::would_overwrite) return error;
  auto details = error.details();
  details.hint = "--replace puts the new one in its place; or choose another place with -o";
  return Error(error.code(), std::move(details));
}

}  // namespace

Result<pki::SignedDocument> verified(const fs::path& file, const fs::path& ca, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxDocumentOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto file_octets, read_file(ca, pki::kMaxBundleOctets));
  auto anchors = with_default_document(pki::Certificate::bundle_from_pem(file_octets), ca);
  DDSSEC_RETURN_IF_ERROR(anchors);
  DDSSEC_ASSIGN_OR_RETURN(
      const auto verifier,
      with_default_document(pki::DocumentVerifier::make(*std::move(anchors)), ca));
  return with_default_document(verifier.verify(octets, now), file);
}

// A text that is not in a signed form is passed to the XML parser, whose error is the most helpful.
Result<DocumentText> unverified_text(const fs::path& file) {
  DDSSEC_ASSIGN_OR_RETURN(auto octets, read_file(file, pki::kMaxDocumentOctets));
  auto form = pki::examine_document(octets);
  using enum pki::DocumentWrapping;
  if (form.wrapping == none || form.wrapping == unknown) return DocumentText{std::move(octets)};
  if (form.ambiguous) return std::unexpected(form.ambiguous->with_default_document(file));
  if (form.unverified_text.empty()) return fail(Code::smime_malformed, {.document = file});
  return DocumentText{std::move(form.unverified_text), form.first_line};
}

std::size_t signed_size(BytesView octets) {
  if (pki::examine_document(octets).wrapping != pki::DocumentWrapping::none) return octets.size();
  // The lines of signed text end in CR LF.
  const auto text = as_text(octets);
  return text.size() + static_cast<std::size_t>(std::ranges::count(text, '\n')) -
         static_cast<std::size_t>(std::ranges::count(text, '\r'));
}

void add_findings(Report& report, std::vector<Finding> findings, const fs::path& file) {
  if (governance::has_errors(findings)) report.exit = Exit::no;
  for (auto& finding : findings) {
    if (finding.document.empty()) finding.document = file;
    report.findings.push_back(std::move(finding));
  }
}

FindingCounts FindingCounts::of(const std::vector<Finding>& findings) {
  FindingCounts out;
  for (const auto& finding : findings)
    ++(finding.severity >= Severity::error     ? out.errors
       : finding.severity == Severity::warning ? out.warnings
                                               : out.notes);
  return out;
}

std::string FindingCounts::words() const {
  std::string out;
  for (const auto& [count, word] :
       {std::pair(errors, "error"), std::pair(warnings, "warning"), std::pair(notes, "note")})
    if (count > 0) out += (out.empty() ? "" : ", ") + count_text(count, word);
  return out.empty() ? "nothing found" : out;
}

std::string counts_text(const std::vector<Finding>& findings) {
  return FindingCounts::of(findings).words();
}

Result<governance::Profile> profile_option(const Arguments& arguments) {
  const auto word = arguments.text("--profile");
  if (const auto profile = governance::profile_from(word)) return *profile;
  return fail(
      Code::usage,
      {.field = "--profile", .expected = "open, balanced or strict", .found = '"' + word + '"'});
}

Result<DomainId> domain_of(const Arguments& arguments) {
  DDSSEC_ASSIGN_OR_RETURN(const auto domain,
                          arguments.number("--domain", 0, governance::kMaxGovernedDomainId));
  return static_cast<DomainId>(domain);
}

Result<std::optional<DomainId>> domain_option(const Arguments& arguments) {
  if (!arguments.has("--domain")) return std::nullopt;
  DDSSEC_ASSIGN_OR_RETURN(auto domain_id, domain_of(arguments));
  return domain_id;
}

Result<std::vector<governance::DomainRange>> domain_ranges(const Arguments& arguments,
                                                           std::string_view option) {
  std::vector<governance::DomainRange> out;
  for (const auto& text : arguments.all(option)) {
    const auto range = range_from(text);
    if (!range)
      return fail(Code::usage, {.field = std::string(option),
                                .expected = "a domain such as 3 or a range such as 0-5, up to 230",
                                .found = '"' + text + '"'});
    out.push_back(*range);
  }
  return out;
}

Result<std::vector<std::string>> topics_of(const Arguments& arguments, std::string_view option) {
  for (const auto& topic : arguments.all(option))
    if (topic.find(',') != topic.npos)
      return fail(Code::usage, {.field = std::string(option),
                                .expected = fmt::format("one topic; {} may be repeated", option),
                                .found = '"' + topic + '"'});
  return arguments.all(option);
}

fs::path signed_path(const fs::path& document) {
  return fs::path(document).replace_extension("p7s");
}

Status check_result_place(const fs::path& target, const Arguments& arguments) {
  if (arguments.has("--replace")) return {};
  const auto out = check_nothing_at(target);
  return out ? Status{} : std::unexpected(with_replace_hint(out.error()));
}

Result<WrittenFile> write_result(const fs::path& target, BytesView octets,
                                 const Arguments& arguments) {
  if (arguments.has("--replace")) {
    FileTransaction out;
    DDSSEC_RETURN_IF_ERROR(out.put(target, octets, 0644));
    DDSSEC_ASSIGN_OR_RETURN(const auto written, out.commit());
    return written.front();
  }
  auto out = write_new_file(target, octets, 0644);
  return out ? std::move(out) : std::unexpected(with_replace_hint(out.error()));
}

}  // namespace ddssec::cli
