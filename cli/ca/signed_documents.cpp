#include "cli/ca/signed_documents.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/notices.hpp"
#include "cli/inputs/files.hpp"
#include "pki/certificate_source.hpp"
#include "pki/smime.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
using Standing = pki::SigningLog::Standing;

// The time at which a document of the CA is verified. The CA may have expired since, and its
// successor then signs what it signed while it was valid. At not_after itself it is no longer
// valid.
WallTime within(const pki::Certificate& ca, WallTime now) {
  const auto last = ca.not_after() - std::chrono::seconds(1);
  return std::clamp(now, ca.not_before(), std::max(ca.not_before(), last));
}

Status check_standing(Standing standing, const fs::path& file, const OpenCa& ca) {
  if (standing == Standing::current) return {};
  const auto code =
      standing == Standing::unknown ? tool_code::document_unlogged : tool_code::document_superseded;
  return fail(code, {.document = file,
                     .expected = "a document that " + ca.paths.signed_log.string() + " has",
                     .note = "left as it is",
                     .hint = fmt::format(
                         "read it: ddssec permissions show, or ddssec governance show, {}; if it "
                         "is right, --unlogged signs it; if the CA's key was stolen, the thief may "
                         "have signed it, so sign the XML that you keep instead",
                         file.string())});
}

// The text of a document that the CA's present key did not sign, if the log has it as the last one
// of the file. Otherwise returns `error`.
Result<DocumentOfCa> logged_text(const fs::path& file, const pki::SigningLog& log,
                                 const Error& error) {
  const auto found = unverified_text(file);
  const auto names = logged_names(file);
  const auto is_last = [&](const auto& name) { return log.is_last_of(name, found->xml); };
  const auto may_be = [&](const auto& name) { return !log.has(name) || is_last(name); };
  if (!found || std::ranges::none_of(names, is_last) || !std::ranges::all_of(names, may_be))
    return std::unexpected(error);
  DocumentOfCa out{std::string(as_text(found->xml)), true};
  std::erase(out.text, '\r');
  return out;
}

}  // namespace

std::vector<std::string> logged_names(const fs::path& file) {
  std::error_code ignored;
  const auto given = fs::absolute(file, ignored).lexically_normal();
  const auto folder = fs::weakly_canonical(given.parent_path(), ignored);
  std::vector<std::string> out{given.string()};
  if (!folder.empty() && folder != given.parent_path())
    out.push_back((folder / given.filename()).string());
  return out;
}

std::string signed_line(const pki::Certificate& ca, BytesView text, const fs::path& file,
                        WallTime now, BytesView extended) {
  std::string out;
  for (const auto& name : logged_names(file))
    out += pki::SigningLog::signed_line(text, ca, name, now, extended);
  return out;
}

Status log_signed(const CaPaths& ca, std::string_view lines) {
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (lines.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(check_log_lines(ca.signed_log, lines));
  return append_lines(ca.signed_log, lines, ca.key);
}

Status log_signed(const OpenCa& ca, BytesView text, const fs::path& file, WallTime now,
                  BytesView extended) {
  return log_signed(ca.paths, signed_line(ca.certificate(), text, file, now, extended));
}

Result<pki::SigningLog> read_signing_log(const CaPaths& ca) {
  std::error_code error;
  if (fs::file_size(ca.signed_log, error) == 0 || error == std::errc::no_such_file_or_directory)
    return pki::SigningLog();
  DDSSEC_ASSIGN_OR_RETURN(const auto text, read_file(ca.signed_log, pki::kMaxIssueLogOctets));
  auto log = pki::SigningLog::parse(text);
  notice_unreadable_lines(ca.signed_log, log.unreadable());
  return log;
}

Result<DocumentOfCa> document_of(const fs::path& file, const OpenCa& ca, const pki::SigningLog& log,
                                 bool takes_unlogged, WallTime now) {
  const auto proof = verified(file, ca.paths.certificate, within(ca.certificate(), now));
  if (!proof) return logged_text(file, log, proof.error());
  const auto standing = log.standing(proof->content(), proof->signer(), logged_names(file));
  if (!takes_unlogged) DDSSEC_RETURN_IF_ERROR(check_standing(standing, file, ca));
  DocumentOfCa out{std::string(as_text(proof->content())), standing == Standing::current};
  std::erase(out.text, '\r');
  return out;
}

Result<DocumentOfCa> document_of_former_key(const fs::path& file, const fs::path& trusted,
                                            const OpenCa& ca, const pki::SigningLog& log,
                                            WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto anchors, read_certificates(trusted));
  DDSSEC_ASSIGN_OR_RETURN(const auto proof, verified(file, trusted, within(anchors.front(), now)));
  DDSSEC_RETURN_IF_ERROR(
      check_standing(log.standing(proof.content(), proof.signer(), logged_names(file)), file, ca));
  DocumentOfCa out{std::string(as_text(proof.content())), true};
  std::erase(out.text, '\r');
  return out;
}

bool is_signed_by(const fs::path& file, std::string_view trust_pem, WallTime now) {
  const auto octets = read_file(file, pki::kMaxDocumentOctets);
  auto anchors = pki::Certificate::bundle_from_pem(as_bytes(trust_pem));
  if (!octets || !anchors || anchors->empty()) return false;
  const auto time = within(anchors->front(), now);
  const auto verifier = pki::DocumentVerifier::make(*std::move(anchors));
  return verifier && verifier->verify(*octets, time);
}

}  // namespace ddssec::cli
