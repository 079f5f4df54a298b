// identity revoke: revokes the certificates of a participant.
#include <algorithm>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/ca/list_dates.hpp"
#include "cli/ca/logged_certificate.hpp"
#include "cli/ca/participant_places.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The certificates to revoke.
struct CertificatesToRevoke {
  std::string subject;
  std::vector<std::string> serials = {};            // those that are not revoked yet
  std::vector<std::string> subjects = {};           // the subject of each serial number
  std::string given_serial = {};                    // the certificate that was given
  std::vector<std::string> given_key_digests = {};  // the digests of its key that a log may contain
  std::string unlogged_key = {};                    // the digest of its key if the log lacks it
  // Certificates of the same key that stay valid, in words.
  std::vector<std::string> same_key = {};
  std::vector<std::string> same_key_serials = {};

  void add(const std::string& serial, const std::string& of) {
    serials.push_back(serial);
    subjects.push_back(of);
  }
  std::string in_words() const {
    std::string out;
    for (std::size_t i = 0; i < serials.size(); ++i)
      out += fmt::format("  serial {}  {}\n", serials[i], subjects[i]);
    return out;
  }
};

bool is_serial(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789ABCDEFabcdef") == text.npos;
}

// Certificates that seem to have expired are revoked as well, because the clock may be wrong. The
// log decides which certificates belong to the participant: a device may have put another
// participant's certificate into its folder. A certificate in a separate file stands for its
// subject.
Result<CertificatesToRevoke> certificates_of_participant(const fs::path& given, const OpenCa& ca,
                                                         const pki::IssueLog& log,
                                                         const Arguments& arguments) {
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, certificate_of(given));
  const auto path = certificate_path(given);
  if (!is_logged(certificate, log)) DDSSEC_RETURN_IF_ERROR(check_issuer(certificate, ca, path));
  const auto folder = path.parent_path();
  const auto log_status = log_status_of(certificate, folder, ca.paths, log);
  const bool is_by_itself = path == given && log_status == LogStatus::moved;
  if (!is_by_itself)
    DDSSEC_RETURN_IF_ERROR(
        check_own(certificate, folder, ca.paths, log, arguments.text("--subject")));
  CertificatesToRevoke out{.subject = certificate.subject(), .given_serial = certificate.serial()};
  const auto* own = log.find(certificate.serial());
  // Another tool or an earlier version may have issued it. Its key is logged, so that no later
  // request can use it.
  const bool is_folder = path.filename() == pki::kCertificateFile;
  const pki::KeyDigests key(certificate);
  if ((own == nullptr || !key.contains(own->key)) && log.revoked_serial(key).empty())
    out.unlogged_key = key.canonical();
  out.given_key_digests = key.all();
  if (!log.is_revoked(certificate.serial())) out.add(certificate.serial(), certificate.subject());
  for (const auto& issued : log.issued()) {
    const bool is_of_folder = is_folder && own != nullptr && own->shares_place_with(issued);
    if ((issued.subject == certificate.subject() || is_of_folder) && !issued.revoked &&
        issued.serial != certificate.serial())
      out.add(issued.serial, issued.subject);
  }
  return out;
}

// Finds certificates of the same key under another subject or in another place. If the key was
// stolen, they are revoked too; otherwise they are only named.
void add_same_key(const pki::IssueLog& log, pki::RevocationReason reason,
                  CertificatesToRevoke& out) {
  const auto is_to_be_revoked = [&](const pki::IssuedCertificate& issued) {
    return issued.serial == out.given_serial ||
           std::ranges::find(out.serials, issued.serial) != out.serials.end();
  };
  std::set<std::string> keys(out.given_key_digests.begin(), out.given_key_digests.end());
  for (const auto& issued : log.issued())
    if (is_to_be_revoked(issued)) keys.insert(issued.key);
  keys.erase("");
  for (const auto& issued : log.issued()) {
    if (is_to_be_revoked(issued) || issued.revoked || !keys.contains(issued.key)) continue;
    if (reason == pki::RevocationReason::key_compromise) {
      out.add(issued.serial, issued.subject);
      continue;
    }
    out.same_key_serials.push_back(issued.serial);
    out.same_key.push_back(fmt::format("serial {}  {}", issued.serial, issued.subject));
  }
}

std::string same_key_text(const CertificatesToRevoke& what, const std::string& ca) {
  if (what.same_key.empty()) return "";
  std::string out = "the same key has another certificate, which stays valid:\n";
  for (const auto& one : what.same_key) out += fmt::format("  {}\n", one);
  return out + fmt::format(
                   "  if the key was stolen: ddssec identity revoke {} --ca {} --reason "
                   "keyCompromise\n",
                   what.same_key_serials.front(), shell_word(ca));
}

// The log may contain the name, but revoking by name alone could revoke the wrong participant.
std::unexpected<Error> not_found_error(const std::string& what, const std::string& ca,
                                       const pki::IssueLog& log) {
  std::error_code ignored;
  const auto path = fs::absolute(what, ignored).lexically_normal();
  const auto folder = path.has_filename() ? path : path.parent_path();
  ErrorDetails details{.document = what,
                       .expected = "a participant's folder, its certificate or a serial number",
                       .hint = participants_near(what)};
  for (const auto& issued : log.issued()) {
    const bool is_meant = issued.subject == what || issued.subject == "CN=" + what ||
                          folder_name(issued.folder) == what || issued.folder == folder;
    if (!is_meant || issued.revoked) continue;
    const bool is_here = path_exists(fs::path(issued.folder) / "cert.pem");
    details.hint = fmt::format("the CA's log has it: ddssec identity revoke {} --ca {}",
                               is_here ? shell_word(issued.folder) : issued.serial, shell_word(ca));
  }
  return fail(Code::file_not_found, std::move(details));
}

Result<CertificatesToRevoke> certificates_to_revoke(const Arguments& arguments, const OpenCa& ca,
                                                    const pki::IssueLog& log) {
  const auto what = arguments.text("WHAT");
  if (path_exists(what)) return certificates_of_participant(what, ca, log, arguments);
  if (!is_serial(what)) return not_found_error(what, arguments.text("--ca"), log);
  const auto serial = ascii_upper(what);
  const auto* issued = log.find(serial);
  if (issued == nullptr)
    return fail(Code::serial_unknown, {.document = ca.paths.log, .found = serial});
  CertificatesToRevoke out{
      .subject = issued->subject, .given_serial = serial, .given_key_digests = {issued->key}};
  if (!log.is_revoked(serial)) out.add(serial, issued->subject);
  return out;
}

Result<pki::RevocationReason> reason_of(const Arguments& arguments) {
  const auto word = arguments.text("--reason");
  const auto reason = pki::revocation_reason_from(word);
  if (!reason)
    return fail(Code::usage,
                {.field = "--reason",
                 .expected = "unspecified, keyCompromise, affiliationChanged, superseded, "
                             "cessationOfOperation or privilegeWithdrawn",
                 .found = word});
  return *reason;
}

// Explains which participants notice the new list, and when.
std::string next_steps(const std::string& ca, const ParticipantPlaces& places,
                       const std::vector<std::string>& without_list, const CaPaths& paths,
                       const pki::IssueLog& log) {
  const bool knows_none = places.is_empty();  // the CA only has CAs below it
  if (knows_none && are_all_revoked(log))
    return fmt::format(
        "no other participant in the CA's log needs the list; those of CAs below it do: ddssec crl "
        "distribute DIR... --ca {}\n",
        shell_word(ca));
  auto out = fmt::format(
      "next: ddssec crl distribute {}--ca {}   ({})\n"
      "when the list is in the folder, a participant reads it\n"
      "  with ddssec's plugins (in Cyclone DDS, or embedded): within 2 s, also the first "
      "crl.pem that appears beside its certificate\n"
      "  with the stock plugins of Cyclone DDS or Fast DDS: only when it starts again, and "
      "only if its configuration names the list (ROS 2 names crl.pem of the enclave)\n",
      knows_none ? "DIR... " : "", shell_word(ca),
      knows_none ? "name the folders of all participants below this CA, also those of other CAs "
                   "below it: the log of this CA knows none"
                 : fmt::format("puts the list into {}", count_text(places.here.size(), "folder")));
  if (!without_list.empty()) out += "  no list so far, so that nothing is revoked there:\n";
  for (std::size_t i = 0; i < without_list.size() && i < 10; ++i)
    out += fmt::format("    {}\n", without_list[i]);
  if (without_list.size() > 10) out += fmt::format("    and {} more\n", without_list.size() - 10);
  return out + places_text(places, paths);
}

// A folder that cannot be entered counts as one with a list; crl distribute reports the problem.
std::vector<std::string> without_list(const ParticipantPlaces& places) {
  std::vector<std::string> out;
  for (const auto& folder : places.here) {
    std::error_code error;
    if (!fs::exists(pki::participant_folder(folder).crl, error) && !error) out.push_back(folder);
  }
  return out;
}

struct ListThatRevokes {
  fs::path file;
  ListNumber number;
  WallTime next_update;

  static constexpr auto fields() {
    using Self = ListThatRevokes;
    return std::tuple(field<&Self::file>(), field<&Self::number>(), field<&Self::next_update>());
  }
};

struct RevocationResult {
  using Folders = std::optional<std::vector<std::string>>;
  std::string subject;
  std::vector<std::string> serials, same_key;
  std::optional<ListThatRevokes> crl = {};
  Folders folders = {}, without_list = {}, elsewhere = {}, left_behind = {}, of_other_cas = {};
  std::string revoked = {};        // "(2 certificates)", or the reason why the list is made again
  std::string certificates = {};   // complete lines: the certificates of `serials`
  std::string same_key_text = {};  // complete lines

  static constexpr auto fields() {
    using Self = RevocationResult;
    constexpr auto kIfAny = [](std::string_view note) {
      return FieldOptions{.note = note, .omits_empty = true};
    };
    return std::tuple(
        field<&Self::subject>({.def = "subject"}),
        field<&Self::serials>({.note = "none: revoked before", .def = "serial"}),
        field<&Self::same_key>(
            {.note = "other certificates of the key, which stay valid", .def = "serial"}),
        field<&Self::crl>(kIfAny("unless it was revoked before, as all that follow")),
        field<&Self::folders>(kIfAny("that need the list")),
        field<&Self::without_list>(kIfAny("of these: here, no crl.pem yet")),
        field<&Self::elsewhere>(kIfAny("of these: not on this machine")),
        field<&Self::left_behind>(kIfAny("as for crl distribute")),
        field<&Self::of_other_cas>(kIfAny("as for crl distribute")));
  }
  std::string text() const {
    if (!crl) return fmt::format("{}  revoked already\n{}", subject, same_key_text);
    return fmt::format("{}  revoked {}; revocation list {} holds until {}\n{}{}", subject, revoked,
                       crl->number.text, date(crl->next_update), certificates, same_key_text);
  }

  void add_places(const ParticipantPlaces& places, std::vector<std::string> bare) {
    folders.emplace();
    for (const auto& folder : places.here) folders->push_back(folder.string());
    without_list = std::move(bare);
    elsewhere = places.elsewhere;
    for (const auto& folder : places.other_copies) elsewhere->push_back(folder);
    folders->insert(folders->end(), elsewhere->begin(), elsewhere->end());
    left_behind = places.left_behind;
    of_other_cas = places.of_other_cas;
  }
};

std::string log_lines(const CertificatesToRevoke& what,
                      const std::vector<pki::Revocation>& revocations) {
  std::string out;
  for (const auto& one : revocations) {
    const bool is_own = one.serial == what.given_serial;
    const bool is_new = std::ranges::find(what.serials, one.serial) != what.serials.end();
    if (is_new || (is_own && !what.unlogged_key.empty()))
      out += pki::IssueLog::revoked_line(one, is_own ? what.unlogged_key : "");
  }
  return out;
}

std::string_view how_revoked_before(const CertificatesToRevoke& what) {
  return what.unlogged_key.empty() ? "already, but the list did not say so"
                                   : "already, but the log did not have its key";
}

Result<Answer<RevocationResult>> identity_revoke(const Arguments& arguments,
                                                 const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(const auto reason, reason_of(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const int days, arguments.number("--next-update", 1, kMaxDays));
  CaOpener opener(arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, opener.open("identity"));
  DDSSEC_RETURN_IF_ERROR(check_list_date(now, ca.paths, arguments));
  DDSSEC_ASSIGN_OR_RETURN(auto log, read_issue_log(ca.paths));
  DDSSEC_ASSIGN_OR_RETURN(auto what, certificates_to_revoke(arguments, ca, log));
  add_same_key(log, reason, what);
  Answer<RevocationResult> answer{{what.subject, what.serials, what.same_key_serials}};
  auto& [result, report, has_result] = answer;
  result.same_key_text = same_key_text(what, arguments.text("--ca"));
  if (what.serials.empty() && what.unlogged_key.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(const auto is_complete, lists_all(ca.paths, log));
    if (is_complete) return answer;
  }
  for (const auto& serial : what.serials)
    DDSSEC_RETURN_IF_ERROR(log.add(pki::Revocation{serial, now, reason}));
  const auto lines = log_lines(what, log.revocations());
  DDSSEC_ASSIGN_OR_RETURN(const auto crl, next_crl(ca, log, now, days));
  FileTransaction out;
  DDSSEC_ASSIGN_OR_RETURN(const auto lists, file_of_lists(ca.paths, crl));
  DDSSEC_RETURN_IF_ERROR(out.put_public(ca.paths.crl, lists));
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  // The log is written first: if the machine stops here, the next list is made from it.
  if (!lines.empty()) DDSSEC_RETURN_IF_ERROR(log_issued(ca.paths, lines));
  result.crl = ListThatRevokes{ca.paths.crl, ListNumber::of(crl), *crl.next_update()};
  result.revoked = what.serials.empty()
                       ? std::string(how_revoked_before(what))
                       : fmt::format("({})", count_text(what.serials.size(), "certificate"));
  result.certificates = what.in_words();
  DDSSEC_ASSIGN_OR_RETURN(const auto places, participant_places(ca.paths, log));
  const auto bare = without_list(places);
  result.add_places(places, bare);
  report.text = next_steps(arguments.text("--ca"), places, bare, ca.paths, log);
  report.text += list_date_warning(crl, now, arguments.text("--ca"));
  // A participant that has moved may still have its certificate of the former CA.
  DDSSEC_ASSIGN_OR_RETURN(const auto overlap, read_overlap(ca.paths));
  if (overlap) {
    report.errors.emplace_back(tool_code::revoked_after_overlap,
                               ErrorDetails{.document = ca.paths.certificate});
    report.exit = Exit::no;
  }
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, out.commit());
  return answer;
}

}  // namespace

std::vector<Command> identity_revoke_commands() {
  return {{.group = "identity",
           .name = "revoke",
           .summary = "Declares a certificate void and makes the revocation list that says so.",
           .positionals =
               {{"WHAT",
                 "a participant's folder or certificate (all that the CA issued to it), or one "
                 "serial number"}},
           .options = {ca_option("the CA that issued it"),
                       {"--reason", "WORD", "why, in the words of RFC 5280", "unspecified"},
                       kSubjectOfFolder,
                       kNextUpdate,
                       kClockIsRight,
                       kPassphraseFile,
                       kPassphraseEnv,
                       kInsecureKeyMode},
           .examples = {"ddssec identity revoke talker --ca ca --reason keyCompromise"},
           .run = identity_revoke,
           .sought_in = {"keystore"}}};
}

}  // namespace ddssec::cli
