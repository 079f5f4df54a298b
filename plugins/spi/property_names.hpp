// Names of the properties that configure the plugins, as the standard and the hosts spell them.
#pragma once

#include <string_view>

namespace ddssec::spi::property {

// DDS-Security 1.2, clause 10.3.1
inline constexpr std::string_view kIdentityCa = "dds.sec.auth.identity_ca";
inline constexpr std::string_view kIdentityCertificate = "dds.sec.auth.identity_certificate";
inline constexpr std::string_view kPrivateKey = "dds.sec.auth.private_key";
inline constexpr std::string_view kPassword = "dds.sec.auth.password";
inline constexpr std::string_view kTrustedCaDir = "dds.sec.auth.trusted_ca_dir";
/// The name in Cyclone DDS; rmw_cyclonedds sets it too.
inline constexpr std::string_view kCrl = "org.eclipse.cyclonedds.sec.auth.crl";
/// Specific to ddssec: a revocation list that need not exist yet when the participant is created.
inline constexpr std::string_view kLaterCrl = "org.ddssec.auth.later_crl";
/// Specific to ddssec: the meaning of a peer's OCSP response: "ignore", "soft" or "hard".
inline constexpr std::string_view kOcsp = "org.ddssec.auth.ocsp";
/// Specific to ddssec: the file with our own OCSP response (DER), which need not exist yet when the
/// participant is created.
inline constexpr std::string_view kOcspResponse = "org.ddssec.auth.ocsp_response";

/// Specific to ddssec: seconds between checks of the files that a running participant reads again
/// when they have changed; 0 means never.
inline constexpr std::string_view kFilesPollInterval = "org.ddssec.files_poll_interval";

/// Specific to ddssec: the file with renewed certificates and permissions of peers, which need not
/// exist yet when the participant is created.
inline constexpr std::string_view kRenewalList = "org.ddssec.renewal_list";

/// Specific to embedded participants: seconds for which peers with the former governance are
/// accepted while a document with more protection is introduced.
inline constexpr std::string_view kGovernanceChangeTime = "org.ddssec.governance_change_time";

/// Specific to embedded participants: "on" lets large samples go to readers of other processes
/// through shared memory (docs/shared-memory.md).
inline constexpr std::string_view kSharedMemory = "org.ddssec.shm";
/// Specific to ddssec: "true" lets payloads be in shared memory unencrypted although messages or
/// submessages are encrypted.
inline constexpr std::string_view kTrustKernel = "org.ddssec.shm.trust_kernel";
/// Specific to ddssec: limit for the shared memory that a participant creates, in octets.
inline constexpr std::string_view kMaxSharedOctets = "org.ddssec.shm.max_octets";
/// Specific to ddssec: "true" lets samples go through shared memory to processes of other users,
/// too.
inline constexpr std::string_view kSharedWithOtherUsers = "org.ddssec.shm.other_users";

/// Specific to embedded participants: microseconds for which a thread looks for input before it
/// sleeps.
inline constexpr std::string_view kBusyWait = "org.ddssec.busy_wait";

/// Specific to ddssec: seconds for which a calendar that was set while participants run is not
/// trusted; with 0 it counts at once.
inline constexpr std::string_view kClockStepGrace = "org.ddssec.clock_step_grace";

/// Specific to ddssec: numbers of days before the end of the participant's certificate, its
/// revocation list or its permissions at which to warn, "30,7,1"; 0 means never.
inline constexpr std::string_view kWarnBeforeEnd = "org.ddssec.warn_before_end";

/// Specific to ddssec, in the IdentityToken: ciphers that are not in the standard.
inline constexpr std::string_view kAnnouncedCiphers = "org.ddssec.symmetric_ciphers";

// DDS-Security 1.2, clause 10.4.1
inline constexpr std::string_view kPermissionsCa = "dds.sec.access.permissions_ca";
inline constexpr std::string_view kGovernance = "dds.sec.access.governance";
inline constexpr std::string_view kPermissions = "dds.sec.access.permissions";
/// Specific to ddssec, for a participant, writer or reader in Cyclone DDS: "true" lets its
/// protected samples pass through shared memory, where every process of the machine that may open
/// it can read them.
inline constexpr std::string_view kAllowSharedMemory = "org.ddssec.access.allow_shared_memory";

// Cryptography
inline constexpr std::string_view kKeySize = "dds.sec.crypto.keysize";
/// The cipher of a writer's or reader's keys; of a participant: the one for its user endpoints
/// (DDS-Security 1.2).
inline constexpr std::string_view kSymmetricCipher = "dds.sec.crypto.symmetric_cipher_algorithm";
/// Specific to ddssec: the cipher of a participant's protected messages and builtin endpoints; AES
/// unless another one is requested.
inline constexpr std::string_view kMessageCipher =
    "org.ddssec.crypto.message_symmetric_cipher_algorithm";
// The passphrase of a domain's pre-shared keys (DDS-Security 1.2, clause 10.5.1), ID:PASSPHRASE, by
// file: or data:.
inline constexpr std::string_view kPskPassphrase = "dds.sec.crypto.rtps_psk_secret_passphrase";
/// Further passphrases, one per line, that are accepted while passphrases are changed.
inline constexpr std::string_view kPskExtraPassphrases =
    "dds.sec.crypto.rtps_psk_secret_passphrase_extra";
inline constexpr std::string_view kPskCipher = "dds.sec.crypto.rtps_psk_symmetric_cipher_algorithm";
/// Specific to ddssec: how long (seconds) and for how much (blocks of 16 octets) keys are used
/// before a participant revises them; 0 means no limit. They require a governance that enables key
/// revision.
inline constexpr std::string_view kKeyLifetime = "org.ddssec.crypto.key_lifetime";
inline constexpr std::string_view kMaxBlocksPerKey = "org.ddssec.crypto.max_blocks_per_key";
/// Specific to ddssec, in Cyclone DDS: "true" passes type information of peers to its core. Any
/// peer can crash the core by it.
inline constexpr std::string_view kTrustTypeInformation =
    "org.ddssec.crypto.trust_type_information";
inline constexpr std::string_view kBuiltinEndpointName = "dds.sec.builtin_endpoint_name";

/// All properties that configure a participant. A file of properties may contain only these names.
inline constexpr std::string_view kOfParticipants[] = {kIdentityCa,
                                                       kIdentityCertificate,
                                                       kPrivateKey,
                                                       kPassword,
                                                       kTrustedCaDir,
                                                       kCrl,
                                                       kLaterCrl,
                                                       kFilesPollInterval,
                                                       kClockStepGrace,
                                                       kPermissionsCa,
                                                       kGovernance,
                                                       kPermissions,
                                                       kAllowSharedMemory,
                                                       kKeySize,
                                                       kSymmetricCipher,
                                                       kMessageCipher,
                                                       kPskPassphrase,
                                                       kPskExtraPassphrases,
                                                       kPskCipher,
                                                       kKeyLifetime,
                                                       kMaxBlocksPerKey,
                                                       kTrustTypeInformation,
                                                       kWarnBeforeEnd,
                                                       kOcsp,
                                                       kOcspResponse,
                                                       kGovernanceChangeTime,
                                                       kRenewalList,
                                                       kSharedMemory,
                                                       kTrustKernel,
                                                       kMaxSharedOctets,
                                                       kSharedWithOtherUsers,
                                                       kBusyWait};

}  // namespace ddssec::spi::property

namespace ddssec::spi::class_id {

inline constexpr std::string_view kIdentity = "DDS:Auth:PKI-DH:1.0";
inline constexpr std::string_view kPermissions = "DDS:Access:Permissions:1.0";
inline constexpr std::string_view kPermissionsCredential = "DDS:Access:PermissionsCredential";
inline constexpr std::string_view kCrypto = "DDS:Crypto:AES_GCM_GMAC";

}  // namespace ddssec::spi::class_id
