// Protection kinds and security attributes, and the masks in which discovery announces them.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "base/protection_kind.hpp"
#include "plugins/spi/match_gate.hpp"
#include "plugins/spi/symmetric_cipher.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

using ddssec::is_encrypted;
using ddssec::is_origin_authenticated;
using ddssec::is_protected;
using ddssec::protection_kind_from;
using ddssec::ProtectionKind;
using ddssec::to_string;

/// ParticipantSecurityAttributes (DDS-Security 1.2, clause 9.4.2.4), with the kinds in place of
/// plugin masks.
struct ParticipantSecurityAttributes {
  bool allow_unauthenticated_participants = false;
  bool is_access_protected = true;
  ProtectionKind rtps = ProtectionKind::none;
  ProtectionKind discovery = ProtectionKind::none;
  ProtectionKind liveliness = ProtectionKind::none;
  /// Protection by a pre-shared key for messages that have no other protection (DDS-Security 1.2):
  /// none, sign or encrypt.
  ProtectionKind rtps_psk = ProtectionKind::none;
  /// The ciphers that <allowed_crypto_algorithms> lists (DDS-Security 1.2); all if the element is
  /// missing.
  CipherMask allowed_ciphers = kAllCiphers;
  /// True if keys are revised when a participant is no longer trusted (DDS-Security 1.2).
  bool is_key_revision_enabled = false;
  /// True if every topic_rule demands protected discovery and the discovery protection kind is not
  /// NONE.
  bool is_all_discovery_protected = false;
  bool operator==(const ParticipantSecurityAttributes&) const = default;

  /// True if the kind is SIGN or ENCRYPT, with or without origin authentication.
  bool is_rtps_protected() const { return is_protected(rtps); }
  bool is_discovery_protected() const { return is_protected(discovery); }
  bool is_liveliness_protected() const { return is_protected(liveliness); }
};

/// TopicSecurityAttributes (DDS-Security 1.2, clause 9.4.2.6).
struct TopicSecurityAttributes {
  bool is_read_protected = false;
  bool is_write_protected = false;
  bool is_discovery_protected = false;
  bool is_liveliness_protected = false;
  bool operator==(const TopicSecurityAttributes&) const = default;
};

/// EndpointSecurityAttributes (DDS-Security 1.2, clause 9.4.2.7). `submessage` is the metadata
/// protection kind, `payload` the data protection kind (none, sign or encrypt). is_key_protected is
/// true if the payload is encrypted.
struct EndpointSecurityAttributes {
  TopicSecurityAttributes topic;
  ProtectionKind submessage = ProtectionKind::none;
  ProtectionKind payload = ProtectionKind::none;
  /// True for an endpoint of the middleware itself, not of the application.
  bool is_builtin = false;
  /// This is asked before a remote participant gets keys. If it is null, there is no check here,
  /// because the host has asked.
  std::shared_ptr<const MatchGate> gate = {};
  bool operator==(const EndpointSecurityAttributes&) const = default;

  /// Returns the masks' bit of the same name, as do the next two (DDS-Security 1.2, clause 7.3.24).
  bool is_submessage_protected() const { return is_protected(submessage); }
  bool is_payload_protected() const { return is_protected(payload); }
  bool is_key_protected() const { return is_encrypted(payload); }
};

/// The two masks of ParticipantSecurityInfo and EndpointSecurityInfo (DDS-Security 1.2,
/// clauses 7.3.23 and 7.3.24).
struct SecurityInfo {
  std::uint32_t mask = 0;
  std::uint32_t plugin_mask = 0;
  bool operator==(const SecurityInfo&) const = default;
};

inline constexpr std::uint32_t kMaskIsValid = 1u << 31;
/// is_key_revision_enabled in a participant's `mask`.
inline constexpr std::uint32_t kKeyRevisionBit = 1u << 3;

/// Returns the masks that discovery announces for a participant or an endpoint, with the valid bits
/// set.
SecurityInfo security_info(const ParticipantSecurityAttributes& attributes);
SecurityInfo security_info(const EndpointSecurityAttributes& attributes);

/// Returns the attributes that a participant's masks state: the kinds of RTPS, discovery,
/// liveliness and pre-shared key protection, and key revision. All other fields keep their
/// defaults. Empty if either mask lacks the valid bit.
std::optional<ParticipantSecurityAttributes> attributes_in(const SecurityInfo& info);

/// Returns the plugin mask alone, including the valid bit (what a host asks for).
std::uint32_t plugin_mask(const ParticipantSecurityAttributes& attributes);
std::uint32_t plugin_mask(const EndpointSecurityAttributes& attributes);

/// The statement of a host's attributes about one kind of protection: the first is their boolean,
/// the other two come from the plugin mask.
struct ProtectionFlags {
  bool is_protected = false;
  bool is_encrypted = false;
  bool is_origin_authenticated = false;
};

/// Returns the kind from a host's attributes. A mask without the valid bit means plain signing
/// (DDS-Security 1.2, clause 10.4.2.4).
ProtectionKind protection_kind(ProtectionFlags flags);

/// True if both masks are equal, or one of a pair lacks the valid bit (DDS-Security 1.2,
/// clause 7.3.23).
bool is_compatible(const SecurityInfo& local, const SecurityInfo& remote);

}  // namespace ddssec::spi
