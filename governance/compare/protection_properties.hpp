// The properties that the protection of a topic provides against three kinds of attackers,
// whichever layer provides them.
#pragma once

#include <bitset>
#include <string_view>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// The properties. An outsider has no identity in the domain. An insider has one, but no right to
/// read or write the topic. A relay stores and forwards samples: it has the keys of submessages and
/// not those of payloads (DDS-Security 1.2, clause 9.5.1.9.3).
enum class ProtectionProperty : std::uint8_t {
  outsider_payload_secrecy,
  outsider_payload_integrity,
  outsider_metadata_secrecy,  ///< sequence numbers, inline QoS, key hashes
  outsider_metadata_integrity,
  outsider_discovery_secrecy,  ///< topic names and QoS do not show in discovery
  outsider_discovery_integrity,
  outsider_liveliness_integrity,
  outsider_bootstrap_secrecy,  ///< announcements and handshakes before there are keys
  outsider_bootstrap_integrity,
  outsider_rejection,  ///< participants that do not authenticate are rejected
  insider_payload_secrecy,
  insider_payload_integrity,
  insider_metadata_secrecy,
  insider_metadata_integrity,
  insider_sender_known,  ///< readers know which writer sent a sample
  insider_join_control,  ///< permissions decide which participants join
  insider_key_revision,  ///< a removed participant does not have the keys that are then in use
  relay_payload_secrecy,
  relay_payload_integrity,
};
inline constexpr std::size_t kProperties = 19;
using Properties = std::bitset<kProperties>;

/// Returns a name such as "insider.payload_secrecy".
std::string_view to_string(ProtectionProperty property);
/// Returns the consequence of its absence, such as "insiders without the right to read can read the
/// payload".
std::string_view without(ProtectionProperty property);

/// All values on which the properties depend, for one topic.
struct Protection {
  bool allow_unauthenticated_participants = false;
  bool enable_join_access_control = true;
  bool enable_key_revision = false;
  ProtectionKind discovery_protection_kind = ProtectionKind::none;
  ProtectionKind liveliness_protection_kind = ProtectionKind::none;
  ProtectionKind rtps_protection_kind = ProtectionKind::none;
  ProtectionKind rtps_psk_protection_kind = ProtectionKind::none;
  bool enable_discovery_protection = false;
  bool enable_liveliness_protection = false;
  bool enable_read_access_control = false;
  bool enable_write_access_control = false;
  ProtectionKind metadata_protection_kind = ProtectionKind::none;
  ProtectionKind data_protection_kind = ProtectionKind::none;

  static Protection of(const DomainRule& domain, const TopicRule& topic);
};

/// Returns the properties that the rules provide for a topic.
Properties properties(const Protection& protection);
Properties properties(const DomainRule& domain, const TopicRule& topic);

/// The properties that change because of one element.
struct Effect {
  Properties lost = {}, gained = {};
};

/// Returns the lost and gained properties from `before` to `after` to which the element called
/// `element` contributes: its change alone makes the difference, or without its change there would
/// be none. An element that is not in Protection contributes nothing.
Effect effect_of(std::string_view element, const Protection& before, const Protection& after);

/// Returns the properties in the set, in order.
std::vector<ProtectionProperty> listed(const Properties& properties);

}  // namespace ddssec::governance
