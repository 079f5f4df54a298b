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
/// Cyclone DDS's name; rmw_cyclonedds sets it too.
inline constexpr std::string_view kCrl = "org.eclipse.cyclonedds.sec.auth.crl";
/// Ours: a list that need not be there yet when the participant is made.
inline constexpr std::string_view kLaterCrl = "org.ddssec.auth.later_crl";
/// Ours: what a peer's OCSP response means: "ignore", "soft" or "hard".
inline constexpr std::string_view kOcsp = "org.ddssec.auth.ocsp";
/// Ours: the file with our own OCSP response (DER), which need not be there yet when the
/// participant is made.
inline constexpr std::string_view kOcspResponse = "org.ddssec.auth.ocsp_response";

/// Ours: seconds between looks at the files that a running participant reads again when they were
/// changed; 0: never.
inline constexpr std::string_view kFilesPollInterval = "org.ddssec.files_poll_interval";

/// Ours: the file with renewed certificates and permissions of peers, which need not be there yet
/// when the participant is made.
inline constexpr std::string_view kRenewalList = "org.ddssec.renewal_list";

/// Ours, of embedded participants: seconds for which peers with the former governance are accepted
/// while a document with more protection is introduced.
inline constexpr std::string_view kGovernanceChangeTime = "org.ddssec.governance_change_time";

/// Ours, of embedded participants: "on" lets large samples go to readers of other processes through
/// shared memory (shared_memory.hpp).
inline constexpr std::string_view kSharedMemory = "org.ddssec.shm";
/// Ours: "true" lets payloads stand in shared memory unencrypted although messages or submessages
/// are encrypted.
inline constexpr std::string_view kTrustKernel = "org.ddssec.shm.trust_kernel";
/// Ours: limit for the shared memory that a participant makes, in octets.
inline constexpr std::string_view kMaxSharedOctets = "org.ddssec.shm.max_octets";
/// Ours: "true" lets samples go through shared memory to processes of other users, too.
inline constexpr std::string_view kSharedWithOtherUsers = "org.ddssec.shm.other_users";

/// Ours: seconds for which a calendar that was set while participants run is not believed; 0: it
/// counts at once.
inline constexpr std::string_view kClockStepGrace = "org.ddssec.clock_step_grace";

/// Ours: how many days before the participant's certificate, its revocation list or its permissions
/// end to warn, "30,7,1"; 0: never.
inline constexpr std::string_view kWarnBeforeEnd = "org.ddssec.warn_before_end";

/// Ours, in the IdentityToken: ciphers that are not the standard's.
inline constexpr std::string_view kAnnouncedCiphers = "org.ddssec.symmetric_ciphers";

// DDS-Security 1.2, clause 10.4.1
inline constexpr std::string_view kPermissionsCa = "dds.sec.access.permissions_ca";
inline constexpr std::string_view kGovernance = "dds.sec.access.governance";
inline constexpr std::string_view kPermissions = "dds.sec.access.permissions";
/// Ours, of a participant, writer or reader in Cyclone DDS: "true" lets its protected samples pass
/// through shared memory, where every process of the machine that may open it reads them.
inline constexpr std::string_view kAllowSharedMemory = "org.ddssec.access.allow_shared_memory";

// Cryptography
inline constexpr std::string_view kKeySize = "dds.sec.crypto.keysize";
/// Of a writer's or reader's keys; of a participant, for its user endpoints (DDS-Security 1.2).
inline constexpr std::string_view kSymmetricCipher = "dds.sec.crypto.symmetric_cipher_algorithm";
/// Ours: of a participant's protected messages and builtin endpoints; AES unless asked for.
inline constexpr std::string_view kMessageCipher =
    "org.ddssec.crypto.message_symmetric_cipher_algorithm";
// DDS-Security 1.2, clause 10.5.1: of a domain's pre-shared keys. ID:PASSPHRASE, by file: or data:.
inline constexpr std::string_view kPskPassphrase = "dds.sec.crypto.rtps_psk_secret_passphrase";
/// A line each: accepted besides, while passphrases are changed.
inline constexpr std::string_view kPskExtraPassphrases =
    "dds.sec.crypto.rtps_psk_secret_passphrase_extra";
inline constexpr std::string_view kPskCipher = "dds.sec.crypto.rtps_psk_symmetric_cipher_algorithm";
/// Ours: how long (seconds) and for how much (blocks of 16 octets) keys are used before a
/// participant revises them; 0: no limit. Only where the governance enables key revision.
inline constexpr std::string_view kKeyLifetime = "org.ddssec.crypto.key_lifetime";
inline constexpr std::string_view kMaxBlocksPerKey = "org.ddssec.crypto.max_blocks_per_key";
/// Ours, in Cyclone DDS: "true" passes type information of peers to its core, which any of them can
/// end by it.
inline constexpr std::string_view kTrustTypeInformation =
    "org.ddssec.crypto.trust_type_information";
inline constexpr std::string_view kBuiltinEndpointName = "dds.sec.builtin_endpoint_name";

/// Every property that configures a participant, and so every name that a file of properties may
/// hold.
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
                                                       kSharedWithOtherUsers};

}  // namespace ddssec::spi::property

namespace ddssec::spi::class_id {

inline constexpr std::string_view kIdentity = "DDS:Auth:PKI-DH:1.0";
inline constexpr std::string_view kPermissions = "DDS:Access:Permissions:1.0";
inline constexpr std::string_view kPermissionsCredential = "DDS:Access:PermissionsCredential";
inline constexpr std::string_view kCrypto = "DDS:Crypto:AES_GCM_GMAC";

}  // namespace ddssec::spi::class_id
