#include "governance/compare/protection_properties.hpp"

#include <algorithm>
#include <variant>

namespace ddssec::governance {
namespace {

struct Row {
  std::string_view name;
  std::string_view without;
};

constexpr std::array<Row, kProperties> kRows = {{
    {"outsider.payload_secrecy", "outsiders can read the payload"},
    {"outsider.payload_integrity", "outsiders can forge the payload"},
    {"outsider.metadata_secrecy", "outsiders can read sequence numbers, inline QoS and key hashes"},
    {"outsider.metadata_integrity", "outsiders can forge sequence numbers and acknowledgements"},
    {"outsider.discovery_secrecy", "outsiders can read the topic's name and QoS in discovery"},
    {"outsider.discovery_integrity", "outsiders can forge announcements of the topic's endpoints"},
    {"outsider.liveliness_integrity", "outsiders can forge that the topic's writers are alive"},
    {"outsider.bootstrap_secrecy", "outsiders can read announcements and handshakes"},
    {"outsider.bootstrap_integrity",
     "outsiders without the pre-shared key can send announcements and handshakes"},
    {"outsider.rejection", "participants without an identity are talked to"},
    {"insider.payload_secrecy", "insiders without the right to read can read the payload"},
    {"insider.payload_integrity", "insiders without the right to write can forge the payload"},
    {"insider.metadata_secrecy", "insiders without the right to read can read sequence numbers"},
    {"insider.metadata_integrity",
     "insiders without the right to write can forge acknowledgements"},
    {"insider.sender_known", "insiders that may read can write in the name of another writer"},
    {"insider.join_control", "insiders join whatever their permissions say"},
    {"insider.key_revision", "insiders that are removed keep the keys in use"},
    {"relay.payload_secrecy", "relays can read the payload"},
    {"relay.payload_integrity", "relays can forge the payload"},
}};

using Member = std::variant<bool Protection::*, ProtectionKind Protection::*>;
struct Element {
  std::string_view name;
  Member member;
};
constexpr std::array<Element, 13> kElements = {{
    {"allow_unauthenticated_participants", &Protection::allow_unauthenticated_participants},
    {"enable_join_access_control", &Protection::enable_join_access_control},
    {"enable_key_revision", &Protection::enable_key_revision},
    {"discovery_protection_kind", &Protection::discovery_protection_kind},
    {"liveliness_protection_kind", &Protection::liveliness_protection_kind},
    {"rtps_protection_kind", &Protection::rtps_protection_kind},
    {"rtps_psk_protection_kind", &Protection::rtps_psk_protection_kind},
    {"enable_discovery_protection", &Protection::enable_discovery_protection},
    {"enable_liveliness_protection", &Protection::enable_liveliness_protection},
    {"enable_read_access_control", &Protection::enable_read_access_control},
    {"enable_write_access_control", &Protection::enable_write_access_control},
    {"metadata_protection_kind", &Protection::metadata_protection_kind},
    {"data_protection_kind", &Protection::data_protection_kind},
}};

// Returns `to`, in which one element has the value of `from`.
Protection with(const Member& member, const Protection& from, Protection to) {
  std::visit([&](auto value) { to.*value = from.*value; }, member);
  return to;
}

}  // namespace

std::string_view to_string(ProtectionProperty property) {
  return kRows.at(static_cast<std::size_t>(property)).name;
}

std::string_view without(ProtectionProperty property) {
  return kRows.at(static_cast<std::size_t>(property)).without;
}

Protection Protection::of(const DomainRule& domain, const TopicRule& topic) {
  return {.allow_unauthenticated_participants = domain.allow_unauthenticated_participants,
          .enable_join_access_control = domain.enable_join_access_control,
          .enable_key_revision = domain.enable_key_revision,
          .discovery_protection_kind = domain.discovery_protection_kind,
          .liveliness_protection_kind = domain.liveliness_protection_kind,
          .rtps_protection_kind = domain.rtps_protection_kind,
          .rtps_psk_protection_kind = domain.rtps_psk_protection_kind,
          .enable_discovery_protection = topic.enable_discovery_protection,
          .enable_liveliness_protection = topic.enable_liveliness_protection,
          .enable_read_access_control = topic.enable_read_access_control,
          .enable_write_access_control = topic.enable_write_access_control,
          .metadata_protection_kind = topic.metadata_protection_kind,
          .data_protection_kind = topic.data_protection_kind};
}

Properties properties(const Protection& p) {
  const auto rtps = p.rtps_protection_kind;
  const auto psk = p.rtps_psk_protection_kind;
  const auto metadata = p.metadata_protection_kind;
  const auto data = p.data_protection_kind;
  const auto discovery =
      p.enable_discovery_protection ? p.discovery_protection_kind : ProtectionKind::none;
  const auto liveliness =
      p.enable_liveliness_protection ? p.liveliness_protection_kind : ProtectionKind::none;
  const bool secret = is_encrypted(metadata) || is_encrypted(data);
  const bool authentic = is_protected(metadata) || is_protected(data);
  Properties result;
  const auto set = [&](ProtectionProperty property, bool value) {
    result.set(static_cast<std::size_t>(property), value);
  };
  using enum ProtectionProperty;
  set(outsider_payload_secrecy, is_encrypted(rtps) || secret);
  set(outsider_payload_integrity, is_protected(rtps) || authentic);
  set(outsider_metadata_secrecy, is_encrypted(rtps) || is_encrypted(metadata));
  set(outsider_metadata_integrity, is_protected(rtps) || is_protected(metadata));
  set(outsider_discovery_secrecy, is_encrypted(rtps) || is_encrypted(discovery));
  set(outsider_discovery_integrity, is_protected(rtps) || is_protected(discovery));
  set(outsider_liveliness_integrity, is_protected(rtps) || is_protected(liveliness));
  set(outsider_bootstrap_secrecy, is_encrypted(psk));
  set(outsider_bootstrap_integrity, is_protected(psk));
  set(outsider_rejection, !p.allow_unauthenticated_participants);
  set(insider_payload_secrecy, secret && p.enable_read_access_control);
  set(insider_payload_integrity, authentic && p.enable_write_access_control);
  set(insider_metadata_secrecy, is_encrypted(metadata) && p.enable_read_access_control);
  set(insider_metadata_integrity, is_protected(metadata) && p.enable_write_access_control);
  set(insider_sender_known, is_origin_authenticated(metadata) || is_origin_authenticated(rtps));
  set(insider_join_control, p.enable_join_access_control);
  set(insider_key_revision, p.enable_key_revision);
  set(relay_payload_secrecy, is_encrypted(data));
  set(relay_payload_integrity, is_protected(data));
  return result;
}

Properties properties(const DomainRule& domain, const TopicRule& topic) {
  return properties(Protection::of(domain, topic));
}

Effect effect_of(std::string_view element, const Protection& before, const Protection& after) {
  const auto found = std::ranges::find(kElements, element, &Element::name);
  if (found == kElements.end()) return {};
  const auto old_properties = properties(before), new_properties = properties(after);
  const auto only_this = properties(with(found->member, after, before));
  const auto all_but_this = properties(with(found->member, before, after));
  // A property is lost because of this element if this change alone loses it, or if it would be
  // kept without this change. Gained properties are found in the same way.
  return {old_properties & ~new_properties & (~only_this | all_but_this),
          ~old_properties & new_properties & (only_this | ~all_but_this)};
}

std::vector<ProtectionProperty> listed(const Properties& properties) {
  std::vector<ProtectionProperty> result;
  for (std::size_t i = 0; i < kProperties; ++i) {
    if (properties.test(i)) result.push_back(static_cast<ProtectionProperty>(i));
  }
  return result;
}

}  // namespace ddssec::governance
