// Cyclone DDS's plugin ABI: the part of its headers that compiles as C++ (the same in 0.10.2 and in
// later versions). Also the data and functions that the three ddssec libraries share across the
// ABI.
#pragma once

#include <cstddef>
#include <cstdint>

#include <dds/security/dds_security_api_access_control.h>
#include <dds/security/dds_security_api_authentication.h>
#include <dds/security/dds_security_api_cryptography.h>
#include <dds/security/dds_security_api_defs.h>
#include <dds/security/dds_security_api_err.h>
#include <dds/security/dds_security_api_types.h>

/// Marks exported functions; everything else in the shared libraries is hidden.
#define DDSSEC_EXPORT extern "C" __attribute__((visibility("default")))

namespace ddssec::cyclonedds {

using Exception = DDS_Security_SecurityException;

/// libddssec_cryptography exports this for libddssec_authentication: it returns the spi::CipherMask
/// of the ciphers that it can decrypt.
using SupportedCiphers = std::uint32_t();
inline constexpr const char* kSupportedCiphersSymbol = "ddssec_supported_ciphers";

/// libddssec_cryptography exports this and the next five for libddssec_authentication. True if that
/// remote participant has sent its keys.
using HasKeysOf = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kHasKeysOfSymbol = "ddssec_has_keys_of";

/// True if it has sent keys for that local participant, the second one.
using HasKeysFor = bool(DDS_Security_IdentityHandle, DDS_Security_IdentityHandle);
inline constexpr const char* kHasKeysForSymbol = "ddssec_has_keys_for";

/// Returns the time of the last decrypted message that only the holder of the shared secret can
/// produce, in nanoseconds of the monotonic clock; 0 for never.
using LastHeardOf = std::int64_t(DDS_Security_IdentityHandle);
inline constexpr const char* kLastHeardOfSymbol = "ddssec_last_heard_of";

/// True if the host has matched that remote participant with the local builtin endpoints.
using IsMatchedWith = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kIsMatchedWithSymbol = "ddssec_is_matched_with";

/// Tells whether that remote participant has proven, since the last call, that it lost its session
/// with a local one.
enum class SessionReset : std::uint8_t {
  none = 0,
  of_session = 1,
  of_unused_session = 2,  ///< its keys never arrived, while those for another local participant did
};
using TakeSessionReset = SessionReset(DDS_Security_IdentityHandle);
inline constexpr const char* kTakeSessionResetSymbol = "ddssec_take_session_reset";

/// True if its keys were dropped since the last call, so that only a new session brings them
/// (spi::CryptoKeyFactory::poll_stranded_keys).
using TakeStrandedKeys = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kTakeStrandedKeysSymbol = "ddssec_take_stranded_keys";

/// Tells a ddssec library that a local participant is cut off. libddssec_authentication and
/// libddssec_access_control call it for cryptography, and libddssec_authentication for access
/// control.
using CutOff = void(DDS_Security_IdentityHandle);
inline constexpr const char* kCutOffCryptographySymbol = "ddssec_cut_off_cryptography";
inline constexpr const char* kCutOffAccessControlSymbol = "ddssec_cut_off_access_control";

/// libddssec_access_control calls this for libddssec_cryptography when the host forgets a reader of
/// this process.
using LookForEndedReaders = void();
inline constexpr const char* kLookForEndedReadersSymbol = "ddssec_look_for_ended_readers";

/// Each ddssec library exports this, for the log line that reports the versions in use.
using PluginVersion = const char*();

/// The question that libddssec_cryptography asks libddssec_access_control before it hands out the
/// keys of a match.
struct MatchQuestion {
  const DDS_Security_PropertySeq* scope;  ///< ac_endpoint_properties of the local endpoint
  DDS_Security_PermissionsHandle remote_permissions;
  /// True for its writer and our reader; false for its reader and our writer.
  DDS_Security_boolean remote_writes;
  const DDS_Security_octet* peer_prefix;  ///< 12 octets of the peer's GUID, or null
  /// See spi::MatchGate::Peer::hides_endpoints.
  DDS_Security_boolean peer_hides_endpoints;
};
enum class MatchVerdict : std::int32_t {
  allowed = 1,
  refused = 0,  ///< an event gives the reason
  unknown_access_control = -1,
  out_of_memory = -2,
};
/// libddssec_access_control exports this. Any thread may call it.
using JudgeMatch = MatchVerdict(const MatchQuestion*);
inline constexpr const char* kJudgeMatchSymbol = "ddssec_judge_match_of_peer";

/// libddssec_access_control exports this for libddssec_authentication. It returns facts about the
/// governance of that local participant, as a mask of GovernanceFact (governance_facts.hpp).
using GovernanceFactsOf = std::uint32_t(DDS_Security_IdentityHandle);
inline constexpr const char* kGovernanceFactsOfSymbol = "ddssec_governance_facts_of";

/// libddssec_access_control exports this for libddssec_authentication. It returns the number of
/// times that the permissions of that local participant were renewed since it was created. If that
/// is more than `known`, `take` is called once, before the function returns, with the signed
/// document that is in force. So a document that access control refused is never presented.
using TakePermissions = void(void* context, const DDS_Security_octet* octets, std::size_t size);
using RenewedPermissions = std::uint64_t(DDS_Security_IdentityHandle, std::uint64_t known,
                                         TakePermissions* take, void* context);
inline constexpr const char* kRenewedPermissionsSymbol = "ddssec_renewed_permissions";
/// libddssec_access_control exports this in the same way. It returns the number of times that
/// renewed permissions of that local participant changed the rights of one of its endpoints so that
/// its sessions must end (OwnEndpoints::poll).
using RightsChanged = std::uint64_t(DDS_Security_IdentityHandle);
inline constexpr const char* kRightsChangedSymbol = "ddssec_rights_changed";
/// libddssec_authentication exports this. The other two libraries call it when a session is to end:
/// it ends now, and not up to a second later. Any thread may call it.
using EndSessionsNow = void();
inline constexpr const char* kEndSessionsNowSymbol = "ddssec_end_sessions_now";
/// libddssec_access_control exports this for libddssec_authentication. The host has forgotten that
/// remote participant: access control drops the permissions handles that the host never returned.
using ReturnPermissionsOf = void(DDS_Security_IdentityHandle);
inline constexpr const char* kReturnPermissionsOfSymbol = "ddssec_return_permissions_of";
/// libddssec_authentication exports a PluginVersion under this name.
inline constexpr const char* kAuthenticationVersionSymbol = "ddssec_authentication_version";

/// The memory behind a DDS_Security_SharedSecretHandle. Cyclone's cryptography plugin reads it and
/// its authentication plugin creates it, so each ddssec plugin works together with the other stock
/// plugin.
struct SharedSecretLayout {
  DDS_Security_octet* shared_secret;
  DDS_Security_long shared_secret_size;
  DDS_Security_octet challenge1[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
  DDS_Security_octet challenge2[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
};

/// The ddssec form, with further fields that only libddssec_cryptography uses. Cyclone's plugin
/// allocates its octets separately from the layout, at addresses that are a multiple of the word
/// size. So its pointer never has the value that the pointer in this form has.
struct ExtendedSharedSecret {
  SharedSecretLayout layout;
  std::uint32_t peer_ciphers;  ///< spi::CipherMask
  /// the BuiltinEndpointSet_t that the peer signed; 0 if unknown
  std::uint32_t peer_builtin_endpoints;
  DDS_Security_octet peer_prefix[12];  ///< the authenticated GUID prefix of the peer, or zeros
  DDS_Security_octet own_guid[16];     ///< GUID of the local participant, or zeros
  DDS_Security_octet octets[64];

  /// Returns the whole object that contains `layout`; nullptr if another plugin made the layout.
  static const ExtendedSharedSecret* of(const SharedSecretLayout& layout);
};
static_assert(offsetof(ExtendedSharedSecret, octets) % alignof(std::max_align_t) == 4);

inline const ExtendedSharedSecret* ExtendedSharedSecret::of(const SharedSecretLayout& layout) {
  const auto* const begin = reinterpret_cast<const DDS_Security_octet*>(&layout);
  if (layout.shared_secret != begin + offsetof(ExtendedSharedSecret, octets)) return nullptr;
  return reinterpret_cast<const ExtendedSharedSecret*>(&layout);
}

}  // namespace ddssec::cyclonedds
