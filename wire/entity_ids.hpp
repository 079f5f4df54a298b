// Entity ids and kinds of RTPS 9.3.1.2, DDS-Security 1.2, clause 7.4.7.1, and DDS-XTypes 1.3, and
// the set of bits that announces them. The product has these numbers in this file only, except
// kEntityIdParticipant (base/ids.hpp).
#pragma once

#include "base/ids.hpp"

namespace ddssec::rtps {

inline constexpr EntityId kEntityIdUnknown{{0, 0, 0, 0}};

inline constexpr EntityId kSpdpWriter{{0x00, 0x01, 0x00, 0xc2}};
inline constexpr EntityId kSpdpReader{{0x00, 0x01, 0x00, 0xc7}};
inline constexpr EntityId kTopicsWriter{{0x00, 0x00, 0x02, 0xc2}};
inline constexpr EntityId kTopicsReader{{0x00, 0x00, 0x02, 0xc7}};
inline constexpr EntityId kPublicationsWriter{{0x00, 0x00, 0x03, 0xc2}};
inline constexpr EntityId kPublicationsReader{{0x00, 0x00, 0x03, 0xc7}};
inline constexpr EntityId kSubscriptionsWriter{{0x00, 0x00, 0x04, 0xc2}};
inline constexpr EntityId kSubscriptionsReader{{0x00, 0x00, 0x04, 0xc7}};
inline constexpr EntityId kParticipantMessageWriter{{0x00, 0x02, 0x00, 0xc2}};
inline constexpr EntityId kParticipantMessageReader{{0x00, 0x02, 0x00, 0xc7}};
inline constexpr EntityId kStatelessMessageWriter{{0x00, 0x02, 0x01, 0xc3}};
inline constexpr EntityId kStatelessMessageReader{{0x00, 0x02, 0x01, 0xc4}};
/// Of DDS-XTypes 1.3, clause 7.6.3.3.3; ddssec has no such endpoints.
inline constexpr EntityId kTypeLookupRequestWriter{{0x00, 0x03, 0x00, 0xc3}};
inline constexpr EntityId kTypeLookupReplyWriter{{0x00, 0x03, 0x01, 0xc3}};
inline constexpr EntityId kPublicationsSecureWriter{{0xff, 0x00, 0x03, 0xc2}};
inline constexpr EntityId kPublicationsSecureReader{{0xff, 0x00, 0x03, 0xc7}};
inline constexpr EntityId kSubscriptionsSecureWriter{{0xff, 0x00, 0x04, 0xc2}};
inline constexpr EntityId kSubscriptionsSecureReader{{0xff, 0x00, 0x04, 0xc7}};
inline constexpr EntityId kParticipantsSecureWriter{{0xff, 0x01, 0x01, 0xc2}};
inline constexpr EntityId kParticipantsSecureReader{{0xff, 0x01, 0x01, 0xc7}};
inline constexpr EntityId kParticipantMessageSecureWriter{{0xff, 0x02, 0x00, 0xc2}};
inline constexpr EntityId kParticipantMessageSecureReader{{0xff, 0x02, 0x00, 0xc7}};
inline constexpr EntityId kVolatileMessageWriter{{0xff, 0x02, 0x02, 0xc3}};
inline constexpr EntityId kVolatileMessageReader{{0xff, 0x02, 0x02, 0xc4}};

/// The low six bits of an entity id's last octet.
enum class EndpointKind : std::uint8_t {
  writer_with_key = 0x02,
  writer_no_key = 0x03,
  reader_no_key = 0x04,
  reader_with_key = 0x07,
};

constexpr std::uint8_t kind_octet(const EntityId& id) { return id.octets[3]; }
constexpr bool is_builtin(const EntityId& id) { return (kind_octet(id) & 0xc0) == 0xc0; }
constexpr bool is_user_defined(const EntityId& id) { return (kind_octet(id) & 0xc0) == 0; }
constexpr bool is_writer(const EntityId& id) {
  const auto kind = kind_octet(id) & 0x3f;
  return kind == 0x02 || kind == 0x03;
}
constexpr bool is_reader(const EntityId& id) {
  const auto kind = kind_octet(id) & 0x3f;
  return kind == 0x04 || kind == 0x07;
}
constexpr bool has_key(const EntityId& id) {
  const auto kind = kind_octet(id) & 0x3f;
  return kind == 0x02 || kind == 0x07;
}

/// Bits of BuiltinEndpointSet_t (RTPS 9.3.2.12, DDS-Security 1.2, clause 7.5.1.4). Each constant
/// has two adjacent bits: the lower one for the writer, the higher one for the reader.
namespace builtin_endpoints {
inline constexpr std::uint32_t kParticipant = 0x3u << 0;
inline constexpr std::uint32_t kPublications = 0x3u << 2;
inline constexpr std::uint32_t kSubscriptions = 0x3u << 4;
inline constexpr std::uint32_t kParticipantMessage = 0x3u << 10;
inline constexpr std::uint32_t kPublicationsSecure = 0x3u << 16;
inline constexpr std::uint32_t kSubscriptionsSecure = 0x3u << 18;
inline constexpr std::uint32_t kParticipantMessageSecure = 0x3u << 20;
inline constexpr std::uint32_t kStatelessMessage = 0x3u << 22;
inline constexpr std::uint32_t kVolatileMessage = 0x3u << 24;
inline constexpr std::uint32_t kParticipantsSecure = 0x3u << 26;
inline constexpr std::uint32_t kWithoutSecurity =
    kParticipant | kPublications | kSubscriptions | kParticipantMessage;
inline constexpr std::uint32_t kWithSecurity =
    kWithoutSecurity | kPublicationsSecure | kSubscriptionsSecure | kParticipantMessageSecure |
    kStatelessMessage | kVolatileMessage | kParticipantsSecure;
}  // namespace builtin_endpoints

}  // namespace ddssec::rtps
