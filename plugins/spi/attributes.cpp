#include "plugins/spi/attributes.hpp"

namespace ddssec::spi {
namespace {

constexpr std::uint32_t bit(bool value, unsigned position) {
  return static_cast<std::uint32_t>(value) << position;
}

bool is_compatible(std::uint32_t local, std::uint32_t remote) {
  return local == remote || (local & remote & kMaskIsValid) == 0;
}

}  // namespace

// Returns the mask of a participant (DDS-Security 1.2, clauses 10.4.2.3 and 10.4.2.4).
std::uint32_t plugin_mask(const ParticipantSecurityAttributes& a) {
  return bit(is_encrypted(a.rtps), 0) | bit(is_encrypted(a.discovery), 1) |
         bit(is_encrypted(a.liveliness), 2) | bit(is_origin_authenticated(a.rtps), 3) |
         bit(is_origin_authenticated(a.discovery), 4) |
         bit(is_origin_authenticated(a.liveliness), 5) | bit(is_encrypted(a.rtps_psk), 6) |
         kMaskIsValid;
}

// Returns the mask of an endpoint (DDS-Security 1.2, clauses 10.4.2.5 and 10.4.2.6).
std::uint32_t plugin_mask(const EndpointSecurityAttributes& a) {
  return bit(is_encrypted(a.submessage), 0) | bit(is_encrypted(a.payload), 1) |
         bit(is_origin_authenticated(a.submessage), 2) | kMaskIsValid;
}

SecurityInfo security_info(const ParticipantSecurityAttributes& a) {
  return {.mask = bit(a.is_rtps_protected(), 0) | bit(a.is_discovery_protected(), 1) |
                  bit(a.is_liveliness_protected(), 2) |
                  (a.is_key_revision_enabled ? kKeyRevisionBit : 0) |
                  bit(is_protected(a.rtps_psk), 4) | kMaskIsValid,
          .plugin_mask = plugin_mask(a)};
}

SecurityInfo security_info(const EndpointSecurityAttributes& a) {
  return {.mask = bit(a.topic.is_read_protected, 0) | bit(a.topic.is_write_protected, 1) |
                  bit(a.topic.is_discovery_protected, 2) | bit(a.is_submessage_protected(), 3) |
                  bit(a.is_payload_protected(), 4) | bit(a.is_key_protected(), 5) |
                  bit(a.topic.is_liveliness_protected, 6) | kMaskIsValid,
          .plugin_mask = plugin_mask(a)};
}

std::optional<ParticipantSecurityAttributes> attributes_in(const SecurityInfo& info) {
  if ((info.mask & info.plugin_mask & kMaskIsValid) == 0) return std::nullopt;
  const auto has = [](std::uint32_t mask, unsigned position) {
    return (mask >> position & 1) != 0;
  };
  const auto kind = [&](unsigned position) {
    return protection_kind({.is_protected = has(info.mask, position),
                            .is_encrypted = has(info.plugin_mask, position),
                            .is_origin_authenticated = has(info.plugin_mask, position + 3)});
  };
  ParticipantSecurityAttributes out;
  out.rtps = kind(0);
  out.discovery = kind(1);
  out.liveliness = kind(2);
  out.rtps_psk = protection_kind(
      {.is_protected = has(info.mask, 4), .is_encrypted = has(info.plugin_mask, 6)});
  out.is_key_revision_enabled = (info.mask & kKeyRevisionBit) != 0;
  return out;
}

ProtectionKind protection_kind(ProtectionFlags flags) {
  if (!flags.is_protected) return ProtectionKind::none;
  if (flags.is_origin_authenticated)
    return flags.is_encrypted ? ProtectionKind::encrypt_with_origin_authentication
                              : ProtectionKind::sign_with_origin_authentication;
  return flags.is_encrypted ? ProtectionKind::encrypt : ProtectionKind::sign;
}

bool is_compatible(const SecurityInfo& local, const SecurityInfo& remote) {
  return is_compatible(local.mask, remote.mask) &&
         is_compatible(local.plugin_mask, remote.plugin_mask);
}

}  // namespace ddssec::spi
