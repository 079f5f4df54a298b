// The folder of a new enclave, which may already contain folders of deeper enclaves.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"

namespace ddssec::cli {

/// Collects the files of one enclave. If there is no folder with the name, it appears with all
/// files at once. If there is one, the files are put into it like those of a FileTransaction.
/// Folders of deeper enclaves in it stay as they are.
class EnclaveFolder {
 public:
  /// The reaction to an existing file of the enclave.
  enum class Existing : std::uint8_t { refused, replaced };

  /// Begins the folder. Errors: enclave_name_unusable if a link leads out of the keystore; those of
  /// NewFolder::at.
  static Result<EnclaveFolder> at(const std::filesystem::path& keystore,
                                  const std::filesystem::path& target, Existing existing);

  /// These do the same as in NewFolder, with names inside the enclave's folder. If something else
  /// has the place of a link, it is replaced by a copy of what the link would lead to.
  Status add(const std::filesystem::path& name, BytesView octets, unsigned mode);
  Status add_public(const std::filesystem::path& name, std::string_view text);
  Status link(const std::filesystem::path& name, const std::filesystem::path& to);
  Result<std::vector<WrittenFile>> commit();

 private:
  explicit EnclaveFolder(std::filesystem::path target) : target_(std::move(target)) {}

  std::filesystem::path target_;
  Existing existing_ = Existing::refused;
  std::optional<NewFolder> folder_ = std::nullopt;    ///< begins at or above the target
  std::filesystem::path below_ = {};                  ///< the target within it
  std::unique_ptr<FileTransaction> files_ = nullptr;  ///< used if the folder exists
  /// The links with their targets; created before the files.
  std::vector<std::pair<std::filesystem::path, std::filesystem::path>> links_ = {};
};

}  // namespace ddssec::cli
