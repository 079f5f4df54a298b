#include "cli/participant/keystore.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/suggestions.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

bool is_token(std::string_view token) {
  const auto is_letter = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || c == '_';
  };
  return !token.empty() && is_letter(token[0]) &&
         std::ranges::all_of(token, [&](char c) { return is_letter(c) || ('0' <= c && c <= '9'); });
}

// The relative path from an enclave's folder up to enclaves/.
fs::path up_to_enclaves(std::string_view name) {
  fs::path out;
  for (const auto& part : fs::path(name).relative_path())
    if (!part.empty()) out /= "..";
  return out;
}

}  // namespace

Status check_enclave(std::string_view name) {
  constexpr std::size_t kMaxOctets = 255;
  const auto wrong = [&] {
    return fail(Code::enclave_name_unusable,
                {.found = '"' + std::string(name.substr(0, kMaxOctets)) + '"'});
  };
  if (name == "/") return {};
  if (name.size() > kMaxOctets || !name.starts_with('/')) return wrong();
  int depth = 0;
  for (auto rest = name.substr(1);;) {
    const auto slash = std::min(rest.find('/'), rest.size());
    if (!is_token(rest.substr(0, slash)) || ++depth > kMaxEnclaveDepth) return wrong();
    if (slash == rest.size()) return {};
    rest.remove_prefix(slash + 1);
  }
}

namespace {

// The user may have given a folder inside a keystore in place of the keystore.
std::string keystore_above(const fs::path& folder) {
  for (auto at = folder.lexically_normal(); at.has_parent_path() && at != at.parent_path();) {
    at = at.parent_path();
    if (path_exists(at / "enclaves/governance.p7s"))
      return fmt::format("name the keystore: {}", at.string());
  }
  return {};
}

}  // namespace

Status check_keystore(const fs::path& keystore) {
  if (!path_exists(keystore))
    return fail(Code::file_not_found, {.document = keystore, .expected = "a keystore"});
  for (const auto* file : {"public/permissions_ca.cert.pem", "public/identity_ca.cert.pem",
                           "private/permissions_ca.key.pem", "private/identity_ca.key.pem",
                           "enclaves/governance.p7s"}) {
    std::error_code ignored;
    if (!fs::is_regular_file(keystore / file, ignored))
      return fail(Code::keystore_incomplete,
                  {.document = keystore / file, .hint = keystore_above(keystore)});
  }
  return {};
}

Status check_enclave_in(const fs::path& keystore, std::string_view name) {
  const auto folder = keystore / enclave_folder(name);
  if (path_exists(folder)) return {};
  const auto meant = nearest(name, enclaves_of(keystore).names);
  return fail(
      Code::file_not_found,
      {.document = folder,
       .note = "the keystore has no such enclave",
       .hint = meant.empty() ? fmt::format("ddssec keystore list {} lists them", keystore.string())
                             : fmt::format("is {} meant?", meant)});
}

fs::path enclave_folder(std::string_view name) {
  const auto below = fs::path(name).relative_path();
  return below.empty() ? fs::path("enclaves") : "enclaves" / below;
}

Status add_keystore_cas(NewFolder& keystore, const KeystoreCas& cas,
                        const pki::Passphrase* passphrase) {
  if (cas.are_one) {
    DDSSEC_RETURN_IF_ERROR(
        keystore.add_public("public/ca.cert.pem", cas.identity.certificate().pem()));
    DDSSEC_RETURN_IF_ERROR(
        add_key(keystore, "private/ca.key.pem", {cas.identity.key()}, passphrase));
    for (const std::string role : {"identity_ca", "permissions_ca"}) {
      DDSSEC_RETURN_IF_ERROR(keystore.link("public/" + role + ".cert.pem", "ca.cert.pem"));
      DDSSEC_RETURN_IF_ERROR(keystore.link("private/" + role + ".key.pem", "ca.key.pem"));
    }
    return {};
  }
  DDSSEC_RETURN_IF_ERROR(
      keystore.add_public("public/identity_ca.cert.pem", cas.identity.certificate().pem()));
  DDSSEC_RETURN_IF_ERROR(
      keystore.add_public("public/permissions_ca.cert.pem", cas.permissions.certificate().pem()));
  DDSSEC_RETURN_IF_ERROR(
      add_key(keystore, "private/identity_ca.key.pem", {cas.identity.key()}, passphrase));
  return add_key(keystore, "private/permissions_ca.key.pem", {cas.permissions.key()}, passphrase);
}

Status add_keystore_governance(NewFolder& keystore, std::string_view xml, BytesView signed_octets) {
  DDSSEC_RETURN_IF_ERROR(keystore.add_public("enclaves/governance.xml", xml));
  return keystore.add("enclaves/governance.p7s", signed_octets, 0644);
}

namespace {

template <class Folder>
Status put_enclave(Folder& folder, const fs::path& below, std::string_view name,
                   const NewParticipant& participant) {
  const auto files = pki::participant_folder(below, pki::FolderLayout::sros2);
  const auto up = up_to_enclaves(name);
  DDSSEC_RETURN_IF_ERROR(folder.link(files.identity_ca, up / "../public/identity_ca.cert.pem"));
  DDSSEC_RETURN_IF_ERROR(
      folder.link(files.permissions_ca, up / "../public/permissions_ca.cert.pem"));
  if (!up.empty()) DDSSEC_RETURN_IF_ERROR(folder.link(files.governance, up / "governance.p7s"));
  DDSSEC_RETURN_IF_ERROR(folder.add_public(files.certificate, participant.self.certificate.pem()));
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, participant.self.key.to_pem());
  DDSSEC_RETURN_IF_ERROR(
      pem.expose([&](BytesView octets) { return folder.add(files.key, octets, 0600); }));
  if (participant.permissions.empty()) return {};
  DDSSEC_RETURN_IF_ERROR(folder.add_public(below / "permissions.xml", participant.permissions_xml));
  return folder.add(files.permissions, participant.permissions, 0644);
}

}  // namespace

Status add_enclave(EnclaveFolder& folder, std::string_view name,
                   const NewParticipant& participant) {
  return put_enclave(folder, {}, name, participant);
}

Status add_enclave(NewFolder& folder, const fs::path& below, std::string_view name,
                   const NewParticipant& participant) {
  return put_enclave(folder, below, name, participant);
}

namespace {

// Searches for enclaves folder by folder, so that an unreadable folder hides no other one.
class EnclaveSearch {
 public:
  explicit EnclaveSearch(fs::path root) : root_(std::move(root)) {}

  Enclaves run() {
    search_folder(root_, 0);
    std::ranges::sort(out_.names);
    std::ranges::sort(out_.without_key);
    std::ranges::sort(out_.empty);
    return std::move(out_);
  }

 private:
  // The contents of one folder.
  struct Content {
    bool has_key = false, has_other_file = false, is_empty = true;
    std::vector<fs::path> folders = {}, links = {};
  };

  void search_folder(const fs::path& folder, int depth) {
    if (out_.names.size() >= kMaxEnclaves) return;
    std::error_code error;
    auto content = content_of(folder, error);
    // It is no error if the folder is gone, because another user may remove it at any time.
    if (error && error != std::errc::no_such_file_or_directory) leave_out(folder, error.message());
    if (content.has_key || content.has_other_file) add(folder, content.has_key);
    if (content.is_empty && !error && depth > 0) out_.empty.push_back(name_of(folder));
    for (const auto& link : content.links) leave_out(link, "a link to a folder is not followed");
    if (depth == kMaxEnclaveDepth && !content.folders.empty())
      return leave_out(folder, fmt::format("there are folders deeper than {}", kMaxEnclaveDepth));
    std::ranges::sort(content.folders);
    for (const auto& inner : content.folders) search_folder(inner, depth + 1);
  }

  // The entries that were read before an error are kept.
  static Content content_of(const fs::path& folder, std::error_code& error) {
    Content out;
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) {
      const auto name = at->path().filename().string();
      std::error_code ignored;
      out.is_empty = false;
      // The name of an enclave never begins with a dot; unfinished folders of killed commands do.
      if (name.starts_with('.')) continue;
      if (name == "key.pem" || name == "key.p11") out.has_key = true;
      if (name == "cert.pem" || name == "permissions.p7s") out.has_other_file = true;
      if (at->is_symlink(ignored) && at->is_directory(ignored)) out.links.push_back(at->path());
      if (!at->is_symlink(ignored) && at->is_directory(ignored)) out.folders.push_back(at->path());
    }
    return out;
  }

  std::string name_of(const fs::path& folder) const {
    const auto below = folder.lexically_relative(root_).generic_string();
    return below == "." ? "/" : "/" + below;
  }

  void add(const fs::path& folder, bool has_key) {
    const auto name = name_of(folder);
    out_.names.push_back(name);
    if (!has_key) out_.without_key.push_back(name);
    if (out_.names.size() == kMaxEnclaves)
      leave_out(root_, fmt::format("there are {} enclaves or more", kMaxEnclaves));
  }

  void leave_out(const fs::path& folder, std::string why) {
    out_.unseen.emplace_back(tool_code::keystore_unseen,
                             ErrorDetails{.document = folder.string(), .note = std::move(why)});
  }

  fs::path root_;
  Enclaves out_;
};

}  // namespace

Enclaves enclaves_of(const fs::path& keystore) {
  return EnclaveSearch(keystore / "enclaves").run();
}

void add_unseen(const Enclaves& enclaves, Report& report) {
  for (const auto& error : enclaves.unseen) {
    report.errors.push_back(error);
    report.exit = std::max(report.exit, exit_of(error.code()));
  }
  for (const auto& name : enclaves.without_key)
    report.errors.emplace_back(tool_code::enclave_without_key, ErrorDetails{.found = name});
}

// An enclave may belong to another user, who can replace the key by a link or by another name of
// any file. So the mode of exactly the checked file is changed.
Result<bool> restrict_key_mode(const fs::path& key) {
  if (key.filename() == "key.pem") DDSSEC_RETURN_IF_ERROR(hold_folder(key.parent_path()));
  const int file = ::openat(folder_descriptor(key.parent_path()), key.filename().c_str(),
                            O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return unwritable_error(key, errno);
  struct stat status {};
  const bool is_key =
      ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_nlink == 1;
  const bool is_open = is_key && (status.st_mode & 077) != 0;
  const int error = is_open && !writes_nothing() && ::fchmod(file, 0600) != 0 ? errno : 0;
  ::close(file);
  if (!is_key)
    return fail(Code::file_unwritable,
                {.document = key, .note = "it is no plain file, or one with further names"});
  if (error != 0) return unwritable_error(key, error);
  return is_open;
}

}  // namespace ddssec::cli
