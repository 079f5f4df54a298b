// What the protection of a topic achieves against two attackers, whichever layer does it.
#pragma once

#include <array>
#include <bitset>
#include <string_view>

#include "governance/model.hpp"

namespace ddssec::governance {

/// An outsider has no identity of the domain; an insider has one, but no right to read or to write
/// the topic.
enum class Property : std::uint8_t {
  outsider_payload_secrecy,
  outsider_payload_integrity,
  outsider_metadata_secrecy,  ///< sequence numbers, inline QoS, key hashes
  outsider_metadata_integrity,
  outsider_discovery_secrecy,  ///< topic names and QoS do not show in discovery
  outsider_rejection,          ///< strangers are not talked to
  insider_payload_secrecy,
  insider_payload_integrity,
  insider_metadata_secrecy,
  insider_metadata_integrity,
  insider_sender_known,  ///< readers know which writer sent a sample
};
inline constexpr std::size_t kProperties = 11;
using Properties = std::bitset<kProperties>;

/// "insider.payload_secrecy".
std::string_view to_string(Property property);
/// What is true without it, such as "insiders without the right to read can read the payload".
std::string_view without(Property property);

/// What the rules give a topic.
Properties properties(const DomainRule& domain, const TopicRule& topic);

/// The properties in the set, in order.
std::vector<Property> listed(const Properties& properties);

}  // namespace ddssec::governance
