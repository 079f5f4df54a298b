// The keystore of ROS 2 (SROS2): public/, private/ and enclaves/, with links to the common files in
// each enclave.
#pragma once

#include <filesystem>
#include <string_view>

#include "cli/frame/file_transaction.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/participant/enclave_folder.hpp"
#include "cli/participant/participant.hpp"

namespace ddssec::cli {

/// Success if the five files exist by which ddssec and upstream recognise a keystore. Error:
/// keystore_incomplete, with the first missing file.
Status check_keystore(const std::filesystem::path& keystore);

/// Adds public/ and private/ to a new keystore. Without a permissions CA, as in a keystore made by
/// upstream, the identity CA has both roles: public/ca.cert.pem and links to it. `passphrase` may
/// be nullptr, as ROS 2 expects.
Status add_keystore_cas(NewFolder& keystore, const pki::Authority& identity,
                        const pki::Authority* permissions, const pki::Passphrase* passphrase);

/// Adds enclaves/governance.xml and .p7s to a new keystore.
Status add_keystore_governance(NewFolder& keystore, std::string_view xml, BytesView signed_octets);

/// Adds an enclave's files to a new folder. `below` is the enclave's place in that folder. `name`
/// is its name in the keystore, which determines the targets of the links. For a participant
/// without permissions, no permissions are added.
Status add_enclave(EnclaveFolder& folder, std::string_view name, const NewParticipant& participant);
Status add_enclave(NewFolder& folder, const std::filesystem::path& below, std::string_view name,
                   const NewParticipant& participant);

/// Makes a private key readable only by its owner. Returns true if others could read it. In a dry
/// run it changes nothing. Errors: would_overwrite (the enclave's folder is a link),
/// file_unwritable (not a regular file, or one with further names).
Result<bool> restrict_key_mode(const std::filesystem::path& key);

}  // namespace ddssec::cli
