#include "cli/folders/folder_kind.hpp"

#include <algorithm>
#include <functional>
#include <vector>

#include <fmt/format.h>

#include "cli/folders/ca_paths.hpp"
#include "cli/folders/enclaves.hpp"
#include "cli/frame/missing_path.hpp"
#include "cli/inputs/files.hpp"
#include "pki/certificate_source.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The largest numbers of entries that are read: of one folder, and of all folders together.
constexpr int kMaxInFolder = 1'000;
constexpr int kMaxLooks = 5'000;
constexpr std::size_t kMaxShown = 4;

using FilePredicate = std::function<bool(const fs::path&)>;

// The folder in which the path would be, or the nearest existing folder above it. "" is the current
// folder.
fs::path nearest_folder(const fs::path& missing) {
  std::error_code ignored;
  auto at = without_slash(missing.lexically_normal()).parent_path();
  while (!at.empty() && !fs::is_directory(at, ignored)) {
    if (at == at.parent_path()) return {};
    at = at.parent_path();
  }
  return at;
}

// Finds wanted folders in this folder. Folders that are not wanted are searched one level deeper.
class Search {
 public:
  explicit Search(FilePredicate is_wanted) : is_wanted_(std::move(is_wanted)) {}

  std::vector<fs::path> around(const fs::path& folder, const fs::path& name) {
    search_folder(folder, 2);
    std::ranges::sort(found_);
    std::ranges::stable_partition(found_,
                                  [&](const fs::path& path) { return path.filename() == name; });
    return std::move(found_);
  }

 private:
  void search_folder(const fs::path& folder, int levels) {
    std::error_code error;
    int entries = 0;
    const auto start = folder.empty() ? fs::path(".") : folder;
    for (fs::directory_iterator at(start, error), end; !error && at != end; at.increment(error)) {
      if (++entries > kMaxInFolder || ++looks_ > kMaxLooks) return;
      std::error_code ignored;
      if (!fs::is_directory(at->symlink_status(ignored))) continue;
      const auto path = folder / at->path().filename();
      if (is_wanted_(path))
        found_.push_back(path);
      else if (levels > 1)
        search_folder(path, levels - 1);
    }
  }

  FilePredicate is_wanted_;
  std::vector<fs::path> found_ = {};
  int looks_ = 0;
};

std::string listed(std::string_view words, const std::vector<fs::path>& paths) {
  std::vector<std::string> shown;
  for (const auto& path : paths)
    if (shown.size() < kMaxShown) shown.push_back(path.string());
  if (shown.empty()) return {};
  return fmt::format("{}{}{}", words, fmt::join(shown, ", "),
                     paths.size() > kMaxShown ? ", ..." : "");
}

std::string participants_inside(const fs::path& folder, std::string_view words) {
  return listed(words, Search(pki::is_participant_folder).around(folder, {}));
}

// Returns "a" for "a/b" and "a/b/", and "" for "b". Also returns "a" for "a/ca/identity".
fs::path parent_of(const fs::path& folder) {
  const auto plain = without_slash(folder.lexically_normal());
  return (path_exists(plain / "ca.pem") ? plain.parent_path() : plain).parent_path();
}

bool holds_ca(const fs::path& folder, std::string_view role) {
  return path_exists(ca_paths(folder, role).certificate);
}

std::string cas_near(const fs::path& missing, std::string_view role) {
  const auto wanted = [&](const fs::path& folder) { return holds_ca(folder, role); };
  for (auto at = nearest_folder(missing); !at.empty(); at = at.parent_path()) {
    if (holds_ca(at, role)) return listed("the CA may be ", {at});
    if (at == at.parent_path()) break;
  }
  return listed("CAs here: ", Search(wanted).around(nearest_folder(missing), {}));
}

// Empty for a folder that is not a keystore of ROS 2. The enclaves decide, because the keystore of
// a robot has no private/.
std::string keystore_hint(const fs::path& folder) {
  std::vector<fs::path> enclaves;
  for (const auto& name : enclaves_of(folder).names)
    enclaves.push_back(folder / enclave_folder(name));
  if (enclaves.empty()) return {};
  return fmt::format("ddssec keystore verify {} looks at all its enclaves{}", folder.string(),
                     listed(": ", enclaves));
}

std::string_view other_role(std::string_view role) {
  return role == "identity" ? "permissions" : "identity";
}

Status check_role(const fs::path& given, std::string_view role) {
  const auto folder = without_slash(given.lexically_normal());
  const auto both = folder.parent_path();
  if (folder.filename() != other_role(role) || !path_exists(both / role / "ca.pem")) return {};
  return fail(Code::usage,
              {.field = "--ca",
               .expected = fmt::format("the folder of the {} CA, {}, or of both, {}", role,
                                       (both / role).string(), both.empty() ? "." : both.string()),
               .found = fmt::format("{}, the {} CA's", given.string(), other_role(role))});
}

bool holds_key(const fs::path& file) {
  const auto text = read_file(file, pki::kMaxCertificateOctets);
  return text && as_text(*text).contains("PRIVATE KEY-----");
}

}  // namespace

std::string participants_near(const fs::path& missing) {
  const auto name = without_slash(missing).filename();
  return listed("participants here: ",
                Search(pki::is_participant_folder).around(nearest_folder(missing), name));
}

Status check_participant_folder(const fs::path& given) {
  if (auto status = check_directory(given, "a participant's folder"); !status) {
    auto details = status.error().details();
    details.hint = participants_near(given);
    return fail(status.error().code(), std::move(details));
  }
  const auto files = pki::participant_folder(given);
  if (path_exists(files.certificate) || path_exists(files.identity_ca)) return {};
  if (auto words = keystore_hint(given); !words.empty())
    return fail(Code::file_not_found, {.document = files.certificate,
                                       .note = fmt::format("{} is a keystore", given.string()),
                                       .hint = std::move(words)});
  if (pki::is_ca_folder(given))
    return fail(Code::file_not_found,
                {.document = files.certificate,
                 .note = fmt::format("{} is the folder of a CA", given.string()),
                 .hint = participants_inside(parent_of(given), "participants of it may be ")});
  if (auto inside = participants_inside(given, "it holds participants: "); !inside.empty())
    return fail(Code::file_not_found,
                {.document = files.certificate,
                 .note = fmt::format("{} is no participant's folder", given.string()),
                 .hint = std::move(inside)});
  return {};
}

Status check_not_above_participants(const fs::path& given, std::string_view name) {
  if (pki::is_participant_folder(given)) return {};
  const auto inside = participants_inside(given, "it holds participants: ");
  const bool has_ca = pki::is_ca_folder(given) || pki::is_ca_folder(given / "ca");
  if (inside.empty() && !has_ca) return {};
  return fail(Code::would_overwrite,
              {.document = given,
               .note = inside.empty() ? "it is the folder of a CA" : inside,
               .hint = fmt::format("-o {} makes a folder of its own",
                                   (given / name).lexically_normal().string())});
}

Result<pki::Certificate> certificate_of(const fs::path& given) {
  std::error_code ignored;
  if (!fs::exists(given, ignored))
    return fail(Code::file_not_found, {.document = given,
                                       .expected = "a participant's folder or a certificate",
                                       .hint = participants_near(given)});
  if (fs::is_directory(given, ignored)) DDSSEC_RETURN_IF_ERROR(check_participant_folder(given));
  auto certificate = read_certificate(certificate_path(given));
  if (!certificate && certificate.error().code() == Code::certificate_malformed && holds_key(given))
    return fail(Code::certificate_malformed,
                {.document = given,
                 .note = "it holds a private key",
                 .hint = "name the certificate, cert.pem beside it as a rule, or the folder"});
  return certificate;
}

Status check_ca_folder(const fs::path& given, std::string_view role) {
  if (holds_ca(given, role)) return {};
  std::error_code ignored;
  ErrorDetails details{.document = given,
                       .expected = "the folder of a CA, as ca create or init makes it",
                       .hint = cas_near(given, role)};
  if (fs::is_regular_file(given, ignored)) {
    details.found = "a file";
    if (holds_ca(given.parent_path(), role))
      details.hint = fmt::format("name the folder: {}", given.parent_path().string());
    return fail(Code::file_unreadable, std::move(details));
  }
  if (pki::is_participant_folder(given))
    details.note = "it is a participant's folder";
  else if (fs::exists(given, ignored))
    details.note = fmt::format("there is no {} CA in it", role);
  return fail(Code::file_not_found, std::move(details));
}

Status check_signing_ca(const fs::path& given, std::string_view role) {
  DDSSEC_RETURN_IF_ERROR(check_role(given, role));
  return check_ca_folder(given, role);
}

}  // namespace ddssec::cli
