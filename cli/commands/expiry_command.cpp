// expiry: lists everything that expires, in one table; for users, cron and systemd.
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "base/stable_sort.hpp"
#include "base/text.hpp"
#include "base/time_left.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/options.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "governance/read.hpp"
#include "pki/certificate_source.hpp"
#include "pki/crl.hpp"
#include "pki/ocsp.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFolderDepth = 16;
constexpr std::size_t kMaxFiles = 500'000;
constexpr auto kKinds = "a certificate, a revocation list or permissions";
constexpr std::string_view kOcspResponse = "OCSP response";

// Something that expires.
struct ExpiringItem {
  std::string_view kind;  // "CA", "certificate", "revocation list", "permissions", kOcspResponse
  std::string subject;
  WallTime not_after;
  fs::path file;
  std::vector<fs::path> also_in = {};  // the other files that contain it
  std::string id = {};                 // for a certificate: issuer and serial number
  WallTime not_before = {};            // hosts refuse it before this time
};

// Finds everything that expires below some paths. The same object in several files is one row. A
// document expires with the certificate that signed it, whichever file contains that certificate.
class Search {
 public:
  // Unreadable files, and paths without anything that expires, are listed in unreadable(): a watch
  // that sees nothing must not report success.
  void look_at(const fs::path& path) {
    const auto before = hits_ + unreadable_.size();
    std::error_code error;
    const auto type = fs::status(path, error).type();
    is_folder_ = type == fs::file_type::directory;
    if (is_folder_)
      collect(path, 0);
    else if (type == fs::file_type::none)
      leave_out(path, error.message());
    else
      paths_.insert(path);
    Progress progress("files", paths_.size());
    for (const auto& file : paths_) {
      progress.step();
      look_into(file);
    }
    paths_.clear();
    is_full_ = false;
    if (hits_ + unreadable_.size() > before) return;
    if (is_folder_) {
      unreadable_.emplace_back(
          Code::file_unreadable,
          ErrorDetails{
              .document = path,
              .note = fmt::format("{} is expected in the folder, and there is none", kKinds),
              .hint = "name the folder of a participant, of a CA, or one with such folders in it"});
      return;
    }
    unreadable_.emplace_back(
        Code::file_unreadable,
        ErrorDetails{.document = path, .expected = kKinds, .found = "another file"});
  }

  // Call this after the last path. A link to a folder is accepted if that folder was searched under
  // its own name.
  void diagnose_links() {
    for (const auto& link : links_) {
      std::error_code ignored;
      const auto target = fs::weakly_canonical(link, ignored);
      if (!searched_.contains(target.string()))
        leave_out(link, fmt::format("links to folders are not followed; search {} as well",
                                    target.string()));
    }
  }

  std::vector<ExpiringItem> items() const {
    std::vector<ExpiringItem> out;
    for (const auto& [key, item] : found_) out.push_back(item);
    for (const auto& [key, item] : signers_)
      if (!found_.contains(key)) out.push_back(item);
    stable_sort_by(out,
                   [](const ExpiringItem& e) { return std::tuple(e.not_after, e.file.string()); });
    return out;
  }
  const std::vector<Error>& unreadable() const { return unreadable_; }
  // True if one of the lists that were found names it. The signature of the list is not checked.
  bool is_revoked(const ExpiringItem& item) const { return revoked_.contains(item.id); }

 private:
  void leave_out(const fs::path& path, std::string why) {
    unreadable_.emplace_back(Code::file_unreadable,
                             ErrorDetails{.document = path, .note = std::move(why)});
  }

  static bool leads_nowhere(const fs::directory_entry& entry) {
    std::error_code error;
    return entry.is_symlink(error) && !fs::exists(entry.status(error));
  }

  // Does not follow symbolic links to folders: one may lead to the root of the file system.
  void collect(const fs::path& folder, int depth) {
    if (depth > kMaxFolderDepth)
      return leave_out(folder,
                       fmt::format("folders deeper than {} are not searched", kMaxFolderDepth));
    std::error_code error, ignored;
    searched_.insert(fs::weakly_canonical(folder, ignored).string());
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator() && !is_full_; at.increment(error)) {
      if (at->is_directory(ignored) && !at->is_symlink(ignored)) {
        if (is_of_participant(at->path())) leave_out(at->path(), "it is a folder");
        collect(at->path(), depth + 1);
      } else if (may_have_an_end(at->path()) || leads_nowhere(*at)) {
        add_file(*at);
      } else if (at->is_directory(ignored)) {
        links_.insert(at->path());
      }
    }
    if (error) leave_out(folder, error.message());
    diagnose_certificate_in(folder);
  }

  void diagnose_certificate_in(const fs::path& folder) {
    const auto has = [&](const char* name) {
      std::error_code ignored;
      return fs::exists(fs::symlink_status(folder / name, ignored));
    };
    if (has("cert.pem") || (!has("key.pem") && !has("key.p11"))) return;
    if (has("cert.p11"))
      leave_out(folder / "cert.p11",
                "certificates in tokens are not read; put it there as cert.pem");
    else
      leave_out(folder / "cert.pem", "it is missing in the folder of a participant");
  }

  void add_file(const fs::directory_entry& file) {
    std::error_code error;
    const auto type = file.status(error).type();
    if (type == fs::file_type::regular)
      paths_.insert(file.path());
    else if (type == fs::file_type::not_found || type == fs::file_type::none)
      leave_out(file.path(),
                type == fs::file_type::none ? error.message() : "a link that leads nowhere");
    else
      leave_out(file.path(), "it is no regular file");
    if (paths_.size() < kMaxFiles) return;
    is_full_ = true;
    leave_out(file.path(), fmt::format("it is file number {}; no more are read", kMaxFiles));
  }

  // A key may be readable only by its owner. That is no fault, because a key does not expire.
  static bool is_unreadable_key(const fs::path& file, Code code) {
    return code == Code::file_unreadable && file.stem().string().ends_with("key");
  }

  static bool may_have_an_end(const fs::path& file) {
    const auto ending = file.extension();
    return ending == ".pem" || ending == ".crt" || ending == ".cer" || ending == ".crl" ||
           is_document(file) || is_ocsp_response(file);
  }
  static bool is_ocsp_response(const fs::path& file) { return file.filename() == "ocsp.der"; }
  static bool is_document(const fs::path& file) {
    return file.extension() == ".p7s" || file.extension() == ".smime";
  }
  static bool is_permissions(const fs::path& file) {
    return is_document(file) && file.stem() == "permissions";
  }
  static bool is_of_participant(const fs::path& file) {
    return file.filename() == "cert.pem" || is_permissions(file);
  }

  // Keys and requests have no end. Any other file in which nothing was found counts as not read.
  static bool has_no_end(const fs::path& file, std::string_view text) {
    const auto name = file.stem().string();
    return name.ends_with("key") || (name != "cert" && name != "crl" && !name.ends_with("ca") &&
                                     text.contains("-----BEGIN "));
  }

  // Several links to one file count once.
  void look_into(const fs::path& file) {
    std::error_code ignored;
    if (!seen_.insert(fs::weakly_canonical(file, ignored).string()).second) {
      ++hits_;
      return;
    }
    const auto octets = read_file(file, pki::kMaxDocumentOctets);
    const auto before = hits_;
    const auto status = !octets                  ? Status(std::unexpected(octets.error()))
                        : is_ocsp_response(file) ? look_into_response(file, *octets)
                        : is_document(file)      ? look_into_document(file, *octets)
                                                 : look_into_pem(file, *octets);
    if (!status) {
      if (!is_unreadable_key(file, status.error().code()))
        unreadable_.push_back(status.error().with_default_document(file));
    } else if (is_folder_ && hits_ == before &&
               (is_document(file) || !has_no_end(file, as_text(*octets)))) {
      leave_out(file, fmt::format("it has no {} that can be read",
                                  is_document(file) ? "signer" : "certificate or revocation list"));
    }
  }

  // OpenSSL, and so stock products, accept certificates with each of these labels. The label for
  // trusted certificates contains more than a certificate and is an error.
  static std::string with_usual_labels(std::string_view text) {
    std::string out(text);
    for (const std::string_view label : {"X509 CERTIFICATE-----", "TRUSTED CERTIFICATE-----"})
      for (auto at = out.find(label); at != out.npos; at = out.find(label, at))
        out.replace(at, label.size(), "CERTIFICATE-----");
    return out;
  }

  static ExpiringItem item_of(const pki::Certificate& certificate, const fs::path& file) {
    return {certificate.is_ca() ? "CA" : "certificate",
            certificate.subject(),
            certificate.not_after(),
            file,
            {},
            certificate.issuer() + ' ' + certificate.serial(),
            certificate.not_before()};
  }

  // The certificates of a renewal list belong to other participants and are also in their folders.
  static bool is_renewal_list(const fs::path& file) {
    return file.stem().string().ends_with("renewed");
  }

  Status look_into_pem(const fs::path& file, BytesView octets) {
    if (is_renewal_list(file)) return {};
    const auto text = with_usual_labels(as_text(octets));
    if (text.contains("-----BEGIN CERTIFICATE-----")) {
      DDSSEC_ASSIGN_OR_RETURN(const auto bundle, pki::Certificate::bundle_from_pem(as_bytes(text)));
      for (const auto& certificate : bundle)
        add(item_of(certificate, file), to_hex(certificate.fingerprint()));
    }
    if (text.find("-----BEGIN X509 CRL-----") == text.npos) return {};
    DDSSEC_ASSIGN_OR_RETURN(const auto crls, pki::Crl::all_from(octets));
    for (const auto& crl : crls) {
      DDSSEC_ASSIGN_OR_RETURN(const auto revoked, crl.revoked());
      for (const auto& entry : revoked) revoked_.insert(crl.issuer() + ' ' + entry.serial);
      if (crl.next_update())
        add({.kind = "revocation list",
             .subject = crl.issuer(),
             .not_after = *crl.next_update(),
             .file = file,
             .not_before = crl.this_update()},
            to_hex(sha256(as_bytes(crl.pem()))));
    }
    return {};
  }

  Status look_into_response(const fs::path& file, BytesView octets) {
    DDSSEC_ASSIGN_OR_RETURN(const auto dates, pki::ocsp_dates(octets));
    const auto certificate = read_certificate(fs::path(file).replace_filename("cert.pem"));
    add({.kind = kOcspResponse,
         .subject = certificate ? certificate->subject() : "unknown",
         .not_after = dates.until,
         .file = file,
         .not_before = dates.this_update},
        to_hex(sha256(octets)));
    return {};
  }

  // The date is used whatever the signature is: verify and doctor find a forged date.
  Status look_into_document(const fs::path& file, BytesView octets) {
    const auto form = pki::examine_document(octets);
    if (form.ambiguous) return std::unexpected(*form.ambiguous);
    const auto signers = add_signers(form, file);
    if (as_text(form.unverified_text).find("<permissions") == std::string_view::npos) {
      if (is_permissions(file)) leave_out(file, "it has no <permissions> that can be read");
      return signers;
    }
    DDSSEC_ASSIGN_OR_RETURN(const auto document,
                            governance::read_permissions(form.unverified_text, form.first_line));
    for (const auto& grant : document.grants)
      add({.kind = "permissions",
           .subject = grant.subject_name,
           .not_after = grant.validity.not_after,
           .file = file,
           .not_before = grant.validity.not_before},
          to_hex(sha256(octets)) + grant.subject_name);
    return signers;
  }

  Status add_signers(const pki::DocumentForm& form, const fs::path& file) {
    for (const auto& der : form.signer_certificates) {
      DDSSEC_ASSIGN_OR_RETURN(const auto signer, pki::Certificate::from_der(der));
      signers_.try_emplace(to_hex(signer.fingerprint()), item_of(signer, file));
      ++hits_;
    }
    return {};
  }

  void add(ExpiringItem item, const std::string& key) {
    ++hits_;
    const auto file = item.file;
    const auto [at, is_new] = found_.try_emplace(key, std::move(item));
    if (!is_new) at->second.also_in.push_back(file);
  }

  std::map<std::string, ExpiringItem> found_;
  std::map<std::string, ExpiringItem> signers_;  // from signatures: listed if no file has them
  std::set<fs::path> paths_;
  std::set<std::string> seen_;
  std::set<std::string> searched_;  // folders, by their paths without links
  std::set<fs::path> links_;        // links to folders
  std::set<std::string> revoked_;   // values of ExpiringItem::id
  std::vector<Error> unreadable_;
  std::size_t hits_ = 0;
  bool is_full_ = false;
  bool is_folder_ = false;  // true if a whole folder is searched
};

// The time from which an end counts as soon. An OCSP response lasts for hours or days, and the
// agent renews it when half of its life is over.
WallTime soon_from(const ExpiringItem& item, WallTime now, WallTime horizon) {
  return item.kind == kOcspResponse ? now + (item.not_after - item.not_before) / 2 : horizon;
}

std::string_view state_of(const ExpiringItem& item, WallTime now, WallTime horizon) {
  if (item.not_after <= now) return "expired";
  if (item.not_before > now) return "not yet";
  return item.not_after <= std::min(horizon, soon_from(item, now, horizon)) ? "soon" : "ok";
}

// The words of the events in which running participants report the same.
std::string_view shown(std::string_view state) {
  return state == "soon" ? "ends soon" : state == "expired" ? "ended" : state;
}

struct ExpiryEntry {
  std::string state, kind, subject;
  WallTime not_after;
  std::int64_t days_left;
  fs::path file;
  std::size_t places;
  std::vector<fs::path> also_in;
  std::string when = {};    // the end and its distance
  bool is_quiet = false;    // --quiet leaves this line out
  bool is_verbose = false;  // --verbose names each file

  static constexpr auto fields() {
    using Self = ExpiryEntry;
    return std::tuple(
        field<&Self::state>({.words = "ok|soon|expired|not yet|revoked"}),
        field<&Self::kind>({.words = "CA|certificate|OCSP response|permissions|revocation list"}),
        field<&Self::subject>(), field<&Self::not_after>(), field<&Self::days_left>(),
        field<&Self::file>(), field<&Self::places>({.note = "how many files have it", .min = 1}),
        field<&Self::also_in>({"the other files that have it"}));
  }
  std::string text() const {
    auto out = fmt::format("{:<9} {:<15} {:<35}  {}  {}{}\n", shown(state), kind, when, subject,
                           printable(file.string()),
                           places > 1 ? fmt::format(" and {} more", places - 1) : "");
    if (is_verbose)
      for (const auto& other : also_in)
        out += fmt::format("  also in {}\n", printable(other.string()));
    return out;
  }
};

struct Expiry {
  WallTime until;
  std::vector<ExpiryEntry> entries = {};

  static constexpr auto fields() {
    return std::tuple(field<&Expiry::until>(), field<&Expiry::entries>());
  }
  std::string text() const {
    std::string out;
    for (const auto& entry : entries)
      if (!entry.is_quiet) out += entry.text();
    return out;
  }
};

Result<Answer<Expiry>> expiry(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto within, duration(arguments, "--within"));
  Search search;
  auto paths = arguments.all("PATHS");
  if (paths.empty()) paths = {"."};
  for (const auto& path : paths) search.look_at(path);
  search.diagnose_links();
  const auto now = context.clock.calendar_seconds();
  const auto horizon = now + within;
  Answer<Expiry> out{{horizon}};
  std::size_t due = 0;
  for (const auto& item : search.items()) {
    const auto by_time = state_of(item, now, horizon);
    const auto state = by_time == "ok" && search.is_revoked(item) ? "revoked" : by_time;
    if (by_time != "ok") ++due;
    out.result.entries.push_back(
        {.state = std::string(state),
         .kind = std::string(item.kind),
         .subject = item.subject,
         .not_after = item.not_after,
         .days_left = std::chrono::floor<std::chrono::days>(item.not_after - now).count(),
         .file = item.file,
         .places = item.also_in.size() + 1,
         .also_in = item.also_in,
         .when = in_time(item.not_after, now),
         .is_quiet = by_time == "ok" && arguments.has("--quiet"),
         .is_verbose = arguments.has("--verbose")});
  }
  auto& report = out.report;
  report.errors = search.unreadable();
  report.exit = due > 0 ? Exit::no : report.errors.empty() ? Exit::done : Exit::unreadable;
  return out;
}

}  // namespace

std::vector<Command> expiry_commands() {
  return {{.group = "",
           .name = "expiry",
           .summary = "Shows when certificates, CAs, signers of documents, revocation lists, "
                      "permissions and OCSP responses end; exit 1: one within the time.",
           .positionals = {{"PATHS", "files and folders; without any, this folder", true, true}},
           .options = {{"--within", "TIME", "what counts as soon: 30d, 12h, 4w", "30d"}},
           .examples = {"ddssec expiry fleet ca --within 30d",
                        "ddssec expiry --quiet fleet || mail -s 'certificates end' admin"},
           .run = expiry}};
}

}  // namespace ddssec::cli
