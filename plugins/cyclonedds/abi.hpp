// Cyclone DDS's plugin ABI, the part of its headers that compiles as C++ (the same in 0.10.2 and in
// the later versions), and the layout that its three plugins share behind a handle.
#pragma once

#include <cstddef>
#include <cstdint>

#include <dds/security/dds_security_api_access_control.h>
#include <dds/security/dds_security_api_authentication.h>
#include <dds/security/dds_security_api_cryptography.h>
#include <dds/security/dds_security_api_defs.h>
#include <dds/security/dds_security_api_err.h>
#include <dds/security/dds_security_api_types.h>

/// Exported from the shared libraries; everything else is hidden.
#define DDSSEC_EXPORT extern "C" __attribute__((visibility("default")))

namespace ddssec::cyclonedds {

using Exception = DDS_Security_SecurityException;

/// Our cryptography library exports this beside its entry points, for our authentication library:
/// the spi::CipherMask of what it can decrypt.
using SupportedCiphers = std::uint32_t();
inline constexpr const char* kSupportedCiphersSymbol = "ddssec_supported_ciphers";

/// What libddssec_cryptography shows our authentication: did that remote participant send its keys?
using HasKeysOf = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kHasKeysOfSymbol = "ddssec_has_keys_of";

/// And when a message that only the peer can make by our shared secret was opened last: ns of the
/// monotonic clock, 0 for never.
using LastHeardOf = std::int64_t(DDS_Security_IdentityHandle);
inline constexpr const char* kLastHeardOfSymbol = "ddssec_last_heard_of";

/// And whether the host has matched it with our builtin endpoints.
using IsMatchedWith = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kIsMatchedWithSymbol = "ddssec_is_matched_with";

/// And whether it proved, since the last call, that it has lost its session with us.
using TakeSessionReset = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kTakeSessionResetSymbol = "ddssec_take_session_reset";

/// And whether its keys were given up since the last call, so that only a further session brings
/// them (spi::CryptoKeyFactory::take_stranded_keys).
using TakeStrandedKeys = bool(DDS_Security_IdentityHandle);
inline constexpr const char* kTakeStrandedKeysSymbol = "ddssec_take_stranded_keys";

/// What our authentication and our access control tell our cryptography, and our authentication our
/// access control: that local participant is cut off.
using CutOff = void(DDS_Security_IdentityHandle);
inline constexpr const char* kCutOffCryptographySymbol = "ddssec_cut_off_cryptography";
inline constexpr const char* kCutOffAccessControlSymbol = "ddssec_cut_off_access_control";

/// What our access control tells our cryptography: the host forgets a reader of this process.
using LookForEndedReaders = void();
inline constexpr const char* kLookForEndedReadersSymbol = "ddssec_look_for_ended_readers";

/// Each of our libraries exports one, for the line that says which are in use: the version.
using PluginVersion = const char*();

/// What our cryptography asks our access control before it hands out the keys of a match.
struct MatchQuestion {
  const DDS_Security_PropertySeq* scope;  ///< ac_endpoint_properties of our own endpoint
  DDS_Security_PermissionsHandle remote_permissions;
  DDS_Security_boolean remote_writes;     ///< to our reader, or else it reads from our writer
  const DDS_Security_octet* peer_prefix;  ///< 12 octets of its GUID, or null
};
enum class MatchVerdict : std::int32_t {
  allowed = 1,
  refused = 0,  ///< and an event says why
  unknown_access_control = -1,
  out_of_memory = -2,
};
/// Our access control library exports this beside its entry points. Any thread.
using JudgeMatch = MatchVerdict(const MatchQuestion*);
inline constexpr const char* kJudgeMatchSymbol = "ddssec_judge_match";

/// What our access control shows our authentication of the governance of that local participant: a
/// mask of GovernanceFact (governance_facts.hpp).
using GovernanceFactsOf = std::uint32_t(DDS_Security_IdentityHandle);
inline constexpr const char* kGovernanceFactsOfSymbol = "ddssec_governance_facts_of";

/// What a DDS_Security_SharedSecretHandle points to: Cyclone's own cryptography plugin reads it,
/// and its authentication plugin hands it out, so that ours can stand beside either.
struct SharedSecretLayout {
  DDS_Security_octet* shared_secret;
  DDS_Security_long shared_secret_size;
  DDS_Security_octet challenge1[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
  DDS_Security_octet challenge2[DDS_SECURITY_AUTHENTICATION_CHALLENGE_SIZE];
};

/// Ours, with what only our own cryptography looks for. Cyclone's plugin allocates its octets apart
/// from the layout, at addresses that are a multiple of the word: it never points to where this
/// one's are.
struct ExtendedSharedSecret {
  SharedSecretLayout layout;
  std::uint32_t peer_ciphers;            ///< spi::CipherMask
  std::uint32_t peer_builtin_endpoints;  ///< BuiltinEndpointSet_t that it signed; 0: unknown
  DDS_Security_octet peer_prefix[12];    ///< the GUID prefix that authentication proved, or zeros
  DDS_Security_octet own_guid[16];       ///< of the local participant, or zeros
  DDS_Security_octet octets[64];

  /// The whole behind a layout, or nullptr for another's.
  static const ExtendedSharedSecret* of(const SharedSecretLayout& layout);
};
static_assert(offsetof(ExtendedSharedSecret, octets) % alignof(std::max_align_t) == 4);

inline const ExtendedSharedSecret* ExtendedSharedSecret::of(const SharedSecretLayout& layout) {
  const auto* const begin = reinterpret_cast<const DDS_Security_octet*>(&layout);
  if (layout.shared_secret != begin + offsetof(ExtendedSharedSecret, octets)) return nullptr;
  return reinterpret_cast<const ExtendedSharedSecret*>(&layout);
}

}  // namespace ddssec::cyclonedds
