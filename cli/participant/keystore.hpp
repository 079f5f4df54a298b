// The keystore of ROS 2 (SROS2): public/, private/ and enclaves/, with links to the common files in
// each enclave.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/participant/enclave_folder.hpp"
#include "cli/participant/participant.hpp"

namespace ddssec::cli {

/// The two CAs of a keystore. In a keystore made by upstream they are the same.
struct KeystoreCas {
  const pki::Authority& identity;
  const pki::Authority& permissions;
  bool are_one;  ///< one CA for both roles: public/ca.cert.pem and links to it
};

/// Success if `name` is a valid enclave name: absolute, of tokens of letters, digits and '_' that
/// do not begin with a digit; "/" is the root enclave. Error: enclave_name_unusable.
Status check_enclave(std::string_view name);

/// Success if the five files exist by which ddssec and upstream recognise a keystore. Error:
/// keystore_incomplete, with the first missing file.
Status check_keystore(const std::filesystem::path& keystore);

/// The enclave's folder below the keystore, such as "enclaves/talker_listener/talker".
std::filesystem::path enclave_folder(std::string_view name);

/// Adds public/ and private/ to a new keystore. `passphrase` may be nullptr, as ROS 2 expects.
Status add_keystore_cas(NewFolder& keystore, const KeystoreCas& cas,
                        const pki::Passphrase* passphrase);

/// Adds enclaves/governance.xml and .p7s to a new keystore.
Status add_keystore_governance(NewFolder& keystore, std::string_view xml, BytesView signed_octets);

/// Adds an enclave's files to a new folder. `below` is the enclave's place in that folder. `name`
/// is its name in the keystore, which determines the targets of the links. For a participant
/// without permissions, no permissions are added.
Status add_enclave(EnclaveFolder& folder, std::string_view name, const NewParticipant& participant);
Status add_enclave(NewFolder& folder, const std::filesystem::path& below, std::string_view name,
                   const NewParticipant& participant);

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
inline constexpr int kMaxEnclaveDepth = 16;
inline constexpr std::size_t kMaxEnclaves = 100'000;

/// Makes a private key readable only by its owner. Returns true if others could read it. In a dry
/// run it changes nothing. Errors: would_overwrite (the enclave's folder is a link),
/// file_unwritable (not a regular file, or one with further names).
Result<bool> restrict_key_mode(const std::filesystem::path& key);

}  // namespace ddssec::cli
