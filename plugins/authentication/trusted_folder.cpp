#include "plugins/authentication/trusted_folder.hpp"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/rollback.hpp"
#include "base/uri_source.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

constexpr auto kName = spi::property::kTrustedCaDir;

Error too_many_error(std::size_t most, std::string_view of_what, const std::string& folder) {
  return Error(Code::trusted_ca_dir_too_many,
               {.document = std::string(kName),
                .expected = "at most " + std::to_string(most) + " " + std::string(of_what),
                .found = folder});
}

std::string absolute_path_of(std::string_view value) {
  const auto path = file_named_by(value).value_or(std::string(value));
  std::error_code error;
  const auto absolute = std::filesystem::absolute(path, error);
  return error ? path : absolute.string();
}

Result<TrustedFolder::Authorities> certificates_in(const std::string& path) {
  DDSSEC_ASSIGN_OR_RETURN(const Bytes octets,
                          pki::load_certificates("file:" + path, kName, pki::kMaxBundleOctets));
  return pki::Certificate::bundle_from_pem(octets);
}

TrustedFolder::Authorities all_of(const std::map<std::string, TrustedFolder::Authorities>& files) {
  TrustedFolder::Authorities all;
  for (const auto& [path, authorities] : files)
    all.insert(all.end(), authorities.begin(), authorities.end());
  return all;
}

Sha256Digest digest_of(const TrustedFolder::Authorities& authorities) {
  Bytes octets;
  for (const auto& ca : authorities) {
    const auto one = ca.fingerprint();
    octets.insert(octets.end(), one.begin(), one.end());
  }
  return sha256(octets);
}

}  // namespace

TrustedFolder::TrustedFolder(std::string_view value, std::chrono::seconds interval)
    : path_(absolute_path_of(value)), interval_(interval), folder_("file:" + path_, interval_) {}

Result<TrustedFolder::Authorities> TrustedFolder::read_first() {
  DDSSEC_ASSIGN_OR_RETURN(const auto contents, read());
  for (const auto& [path, authorities] : contents) sources_.push_back(path);
  return all_of(contents);
}

// All files are asked, so that each notes how it is now.
bool TrustedFolder::may_have_changed(std::chrono::nanoseconds now) {
  bool changed = folder_.may_have_changed(now);
  for (auto& [path, watch] : files_) changed = watch.may_have_changed(now) || changed;
  return changed;
}

Result<std::vector<std::string>> TrustedFolder::list_files() const {
  std::error_code error;
  std::filesystem::directory_iterator entries(path_, error);
  std::vector<std::string> paths;
  for (; !error && entries != std::filesystem::directory_iterator(); entries.increment(error)) {
    if (paths.size() == kMaxFiles)
      return std::unexpected(too_many_error(kMaxFiles, "files", path_));
    paths.push_back(entries->path().string());
  }
  if (error)
    return fail(Code::trusted_ca_dir_unreadable,
                {.document = std::string(kName), .found = path_, .note = error.message()});
  return paths;
}

Result<TrustedFolder::Contents> TrustedFolder::read() {
  DDSSEC_ASSIGN_OR_RETURN(const auto paths, list_files());
  std::map<std::string, FileWatch> files;
  for (const auto& path : paths) {
    const auto known = files_.extract(path);
    files.emplace(path, known ? std::move(known.mapped()) : FileWatch("file:" + path, interval_));
  }
  files_ = std::move(files);
  Contents contents;
  std::size_t count = 0;
  for (const auto& [path, watch] : files_) {
    auto authorities = certificates_in(path).value_or(Authorities());
    std::erase_if(authorities, [](const auto& one) { return !one.is_ca(); });
    if (authorities.empty()) continue;
    count += authorities.size();
    if (count > kMaxAuthorities)
      return std::unexpected(too_many_error(kMaxAuthorities, "certificates", path_));
    contents.emplace(path, std::move(authorities));
  }
  return contents;
}

// A file that had CAs and cannot be read any more is a fault. A file that is gone is not.
Status TrustedFolder::check_sources(const Contents& contents) const {
  for (const auto& path : sources_) {
    if (contents.contains(path) || !files_.contains(path)) continue;
    const auto now = certificates_in(path);
    if (now) continue;
    auto details = now.error().details();
    details.note = "the file is " + path + (details.note.empty() ? "" : "; ") + details.note;
    return fail(now.error().code(), std::move(details));
  }
  return {};
}

Result<bool> TrustedFolder::adopt_if_other(const Contents& contents, const Authorities& in_force,
                                           const Adopt& adopt) {
  DDSSEC_RETURN_IF_ERROR(check_sources(contents));
  const auto next = all_of(contents);
  const auto leaves = !pki::leaving(in_force, next).empty();
  const bool is_other = leaves || !pki::leaving(next, in_force).empty();
  if (is_other) {
    DDSSEC_RETURN_IF_ERROR(withdrawn_.check(in_force, next));
    if (leaves && !is_as_at_last_poll_) {
      refusals_.note_doubt();
      return false;
    }
    DDSSEC_RETURN_IF_ERROR(adopt(next));
    withdrawn_.note(in_force, next);
  }
  sources_.clear();
  for (const auto& [path, authorities] : contents) sources_.push_back(path);
  refusals_.clear();
  return is_other;
}

Result<bool> TrustedFolder::poll(std::chrono::nanoseconds now, const Authorities& in_force,
                                 const Adopt& adopt) {
  if (!may_have_changed(now)) return false;
  Rollback again([&] { folder_.force_change(); });
  const auto contents = read();
  const auto content = contents ? digest_of(all_of(*contents)) : Sha256Digest{};
  is_as_at_last_poll_ = contents && last_read_ == content;
  last_read_ = contents ? std::optional(content) : std::nullopt;
  const auto taken = contents ? adopt_if_other(*contents, in_force, adopt)
                              : Result<bool>(std::unexpected(contents.error()));
  if (taken) {
    if (refusals_.state() == FileState::current) again.release();
    return taken;
  }
  if (!refusals_.note_refusal(taken.error().code(), content)) return false;
  return std::unexpected(refusals_.note(
      renewal_refused_error(Code::identity_ca_renewal_refused, taken.error(), path_,
                            "the CAs of the folder that were read before stay in force")));
}

}  // namespace ddssec::authentication
