// The folder of a new enclave, which may already contain folders of deeper enclaves.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/new_folder.hpp"
#include "cli/transaction.hpp"

namespace ddssec::cli {

/// Collects the files of one enclave. If there is no folder with the name, it appears with all
/// files at once. If there is one with deeper enclaves only, the files are put into it like those
/// of a Replacement, and no existing file is replaced.
class EnclaveFolder {
 public:
  /// Errors: enclave_name_unusable if a link leads out of the keystore; those of NewFolder::at.
  static Result<EnclaveFolder> at(const std::filesystem::path& keystore,
                                  const std::filesystem::path& target);

  /// As in NewFolder, with names inside the enclave's folder.
  Status add(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status add_public(const std::filesystem::path& name, std::string_view text);
  Status link(const std::filesystem::path& name, const std::filesystem::path& to);
  Result<std::vector<WrittenFile>> commit();

 private:
  explicit EnclaveFolder(std::filesystem::path target) : target_(std::move(target)) {}

  std::filesystem::path target_;
  std::optional<NewFolder> folder_ = std::nullopt;  ///< begins at or above the target
  std::filesystem::path below_ = {};                ///< the target within it
  std::unique_ptr<Replacement> files_ = nullptr;    ///< used if the folder exists
  /// The links with their targets; created before the files.
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> links_ = {};
};

}  // namespace ddssec::cli
