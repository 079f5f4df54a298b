// The enclaves of a keystore of ROS 2 (SROS2).
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cli/frame/report.hpp"

namespace ddssec::cli {

inline constexpr int kMaxEnclaveDepth = 16;
inline constexpr std::size_t kMaxEnclaves = 100'000;

/// Success if `name` is a valid enclave name: absolute, of tokens of letters, digits and '_' that
/// do not begin with a digit; "/" is the root enclave. Error: enclave_name_unusable.
Status check_enclave(std::string_view name);

/// The enclave's folder below the keystore, such as "enclaves/talker_listener/talker".
std::filesystem::path enclave_folder(std::string_view name);

/// Success if the keystore has the enclave. Error: file_not_found, which proposes an enclave with a
/// similar name.
Status check_enclave_in(const std::filesystem::path& keystore, std::string_view name);

/// The enclaves of a keystore.
struct Enclaves {
  std::vector<std::string> names;        ///< sorted
  std::vector<std::string> without_key;  ///< enclaves in `names` whose key is elsewhere or lost
  std::vector<std::string> empty = {};   ///< sorted; empty folders
  std::vector<Error> unseen = {};        ///< keystore_unseen: folders that were not searched
};

/// Finds all folders below enclaves/ with a private key, a certificate or permissions. `unseen`
/// gets folders that cannot be read or are deeper than kMaxEnclaveDepth, links to folders, which
/// are not followed, and everything after kMaxEnclaves. The search continues with all other
/// folders.
Enclaves enclaves_of(const std::filesystem::path& keystore);

/// Reports folders of a keystore that were not searched; the command then ends with at least
/// Exit::unreadable.
void add_unseen(const Enclaves& enclaves, Report& report);

}  // namespace ddssec::cli
