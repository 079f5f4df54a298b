// The keystore of ROS 2 (SROS2): public/, private/, enclaves/, and in each enclave links to what
// all share.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cli/enclave_folder.hpp"
#include "cli/participant.hpp"
#include "cli/transaction.hpp"

namespace ddssec::cli {

/// The two CAs of a keystore; both the same for a keystore as upstream makes it.
struct KeystoreCas {
  const pki::Authority& identity;
  const pki::Authority& permissions;
  bool are_one;  ///< one CA: public/ca.cert.pem and links to it
};

/// Success if `name` is an enclave's: absolute, of tokens of letters, digits and '_' that do not
/// begin with a digit; "/" is the root enclave. Error: enclave_name_unusable.
Status check_enclave(std::string_view name);

/// Success if the five files are there by which a keystore is known (and by which upstream knows
/// one). Error: keystore_incomplete, with the first that is missing.
Status check_keystore(const std::filesystem::path& keystore);

/// The enclave's folder below the keystore: "enclaves/talker_listener/talker".
std::filesystem::path enclave_folder(std::string_view name);

/// Puts public/ and private/ into a keystore to be. `passphrase` may be null, as ROS 2 expects.
Status add_keystore_cas(NewFolder& keystore, const KeystoreCas& cas,
                        const pki::Passphrase* passphrase);

/// Puts enclaves/governance.xml and .p7s into a keystore to be.
Status add_keystore_governance(NewFolder& keystore, std::string_view xml, BytesView signed_octets);

/// Puts an enclave's files into a folder to be: `below` is its place in that folder, `name` in the
/// keystore, by which the links are made.
Status add_enclave(EnclaveFolder& folder, std::string_view name,
                   const NewParticipant& participant);
Status add_enclave(NewFolder& folder, const std::filesystem::path& below, std::string_view name,
                   const NewParticipant& participant);

/// Success if the keystore has the enclave. Error: file_not_found, which proposes one with a name
/// close to it.
Status check_enclave_in(const std::filesystem::path& keystore, std::string_view name);

/// The enclaves of a keystore.
struct Enclaves {
  std::vector<std::string> names;        ///< sorted
  std::vector<std::string> without_key;  ///< those of `names` whose key is elsewhere, or lost
  std::vector<std::string> empty = {};   ///< sorted; folders that hold nothing at all
  std::vector<Error> unseen = {};        ///< keystore_unseen: folders that were not searched
};

/// Every folder below enclaves/ with a private key, a certificate or permissions. A folder that
/// cannot be read, or lies deeper than kDeepestEnclave, is among `unseen`, and the search goes on
/// with all others; so is a link to a folder, which is not followed, and everything after
/// kMostEnclaves.
Enclaves enclaves_of(const std::filesystem::path& keystore);

/// Reports what was not seen of a keystore, which ends the command with Exit::unreadable at least.
void add_unseen(const Enclaves& enclaves, Report& report);
inline constexpr int kDeepestEnclave = 16;
inline constexpr std::size_t kMostEnclaves = 100'000;

/// Makes a private key readable by its owner only; true if it was not. In a dry run it only looks.
/// Errors: would_overwrite (the enclave's folder is a link), file_unwritable (no plain file, or one
/// with further names).
Result<bool> close_key(const std::filesystem::path& key);

}  // namespace ddssec::cli
