#include "cli/participant/enclave_folder.hpp"

#include <algorithm>
#include <iterator>
#include <system_error>
#include <utility>

#include "cli/inputs/files.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// The new folder begins at the first part of the name that does not exist yet, so that all of it
// appears at once.
fs::path first_new_part(const fs::path& target) {
  std::error_code ignored;
  auto first = target;
  while (!fs::exists(first.parent_path(), ignored)) first = first.parent_path();
  return first;
}

Status check_inside(const fs::path& keystore, const fs::path& folder, const fs::path& target) {
  std::error_code ignored;
  const auto inside = fs::canonical(folder, ignored);
  const auto root = fs::canonical(keystore / "enclaves", ignored);
  if (std::mismatch(root.begin(), root.end(), inside.begin(), inside.end()).first == root.end())
    return {};
  return fail(Code::enclave_name_unusable,
              {.found = target.string(), .note = "a link leads out of the keystore"});
}

// True for folders of deeper enclaves, and for the remains of an interrupted command.
bool is_plain_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() == fs::file_type::directory;
}

bool is_anything(const fs::path& path) {
  std::error_code ignored;
  return fs::symlink_status(path, ignored).type() > fs::file_type::not_found;
}

}  // namespace

Result<EnclaveFolder> EnclaveFolder::at(const fs::path& keystore, const fs::path& target,
                                        Existing existing) {
  EnclaveFolder out(target);
  out.existing_ = existing;
  if (is_plain_folder(target)) {
    DDSSEC_RETURN_IF_ERROR(check_inside(keystore, target, target));
    out.files_ = std::make_unique<FileTransaction>();
    return out;
  }
  const auto first = first_new_part(target);
  DDSSEC_RETURN_IF_ERROR(check_inside(keystore, first.parent_path(), target));
  DDSSEC_ASSIGN_OR_RETURN(auto new_folder, NewFolder::at(first));
  out.folder_.emplace(std::move(new_folder));
  out.below_ = target.lexically_relative(out.folder_->target());
  if (out.below_ == ".") out.below_.clear();
  return out;
}

Status EnclaveFolder::add(const fs::path& name, BytesView octets, unsigned mode) {
  if (folder_) return folder_->add(below_ / name, octets, mode);
  if (existing_ == Existing::refused) DDSSEC_RETURN_IF_ERROR(check_nothing_at(target_ / name));
  return files_->put(target_ / name, octets, mode);
}

Status EnclaveFolder::add_public(const fs::path& name, std::string_view text) {
  return add(name, as_bytes(text), 0644);
}

Status EnclaveFolder::link(const fs::path& name, const fs::path& to) {
  if (folder_) return folder_->link(below_ / name, to);
  const auto place = target_ / name;
  const auto fits = check_link_place(place, to);
  if (!fits && existing_ == Existing::replaced && is_anything(place)) {
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(target_ / to, pki::kMaxDocumentOctets));
    return files_->put(place, octets, 0644, FileTransaction::Links::replaced);
  }
  links_.emplace_back(place, to);
  return fits;
}

Result<std::vector<WrittenFile>> EnclaveFolder::commit() {
  if (folder_) return folder_->commit();
  std::vector<WrittenFile> out;
  for (const auto& [place, to] : links_) {
    DDSSEC_ASSIGN_OR_RETURN(auto link, write_link(place, to));
    out.push_back(std::move(link));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto written, files_->commit());
  std::ranges::move(std::move(written), std::back_inserter(out));
  return out;
}

}  // namespace ddssec::cli
