#include "cli/participant/keystore.hpp"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/tool_code.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The relative path from an enclave's folder up to enclaves/.
fs::path up_to_enclaves(std::string_view name) {
  fs::path out;
  for (const auto& part : fs::path(name).relative_path())
    if (!part.empty()) out /= "..";
  return out;
}

}  // namespace

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

Status add_keystore_cas(NewFolder& keystore, const pki::Authority& identity,
                        const pki::Authority* permissions, const pki::Passphrase* passphrase) {
  if (permissions == nullptr) {
    DDSSEC_RETURN_IF_ERROR(keystore.add_public("public/ca.cert.pem", identity.certificate().pem()));
    DDSSEC_RETURN_IF_ERROR(add_key(keystore, "private/ca.key.pem", {identity.key()}, passphrase));
    for (const std::string role : {"identity_ca", "permissions_ca"}) {
      DDSSEC_RETURN_IF_ERROR(keystore.link("public/" + role + ".cert.pem", "ca.cert.pem"));
      DDSSEC_RETURN_IF_ERROR(keystore.link("private/" + role + ".key.pem", "ca.key.pem"));
    }
    return {};
  }
  DDSSEC_RETURN_IF_ERROR(
      keystore.add_public("public/identity_ca.cert.pem", identity.certificate().pem()));
  DDSSEC_RETURN_IF_ERROR(
      keystore.add_public("public/permissions_ca.cert.pem", permissions->certificate().pem()));
  DDSSEC_RETURN_IF_ERROR(
      add_key(keystore, "private/identity_ca.key.pem", {identity.key()}, passphrase));
  return add_key(keystore, "private/permissions_ca.key.pem", {permissions->key()}, passphrase);
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
