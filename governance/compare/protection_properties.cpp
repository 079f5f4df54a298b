#include "governance/compare/protection_properties.hpp"

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
    {"outsider.rejection", "strangers without an identity are talked to"},
    {"insider.payload_secrecy", "insiders without the right to read can read the payload"},
    {"insider.payload_integrity", "insiders without the right to write can forge the payload"},
    {"insider.metadata_secrecy", "insiders without the right to read can read sequence numbers"},
    {"insider.metadata_integrity",
     "insiders without the right to write can forge acknowledgements"},
    {"insider.sender_known", "a reader can pass itself off as another one's writer"},
}};

}  // namespace

std::string_view to_string(Property property) {
  return kRows.at(static_cast<std::size_t>(property)).name;
}

std::string_view without(Property property) {
  return kRows.at(static_cast<std::size_t>(property)).without;
}

Properties properties(const DomainRule& domain, const TopicRule& topic) {
  const auto rtps = domain.rtps_protection_kind;
  const auto metadata = topic.metadata_protection_kind;
  const auto data = topic.data_protection_kind;
  const bool secret = is_encrypted(metadata) || is_encrypted(data);
  const bool authentic = is_protected(metadata) || is_protected(data);
  const bool hidden =
      topic.enable_discovery_protection && is_encrypted(domain.discovery_protection_kind);
  Properties result;
  const auto set = [&](Property p, bool value) { result.set(static_cast<std::size_t>(p), value); };
  using enum Property;
  set(outsider_payload_secrecy, is_encrypted(rtps) || secret);
  set(outsider_payload_integrity, is_protected(rtps) || authentic);
  set(outsider_metadata_secrecy, is_encrypted(rtps) || is_encrypted(metadata));
  set(outsider_metadata_integrity, is_protected(rtps) || is_protected(metadata));
  set(outsider_discovery_secrecy, is_encrypted(rtps) || hidden);
  set(outsider_rejection, !domain.allow_unauthenticated_participants);
  set(insider_payload_secrecy, secret && topic.enable_read_access_control);
  set(insider_payload_integrity, authentic && topic.enable_write_access_control);
  set(insider_metadata_secrecy, is_encrypted(metadata) && topic.enable_read_access_control);
  set(insider_metadata_integrity, is_protected(metadata) && topic.enable_write_access_control);
  set(insider_sender_known, is_origin_authenticated(metadata));
  return result;
}

std::vector<Property> listed(const Properties& properties) {
  std::vector<Property> result;
  for (std::size_t i = 0; i < kProperties; ++i) {
    if (properties.test(i)) result.push_back(static_cast<Property>(i));
  }
  return result;
}

}  // namespace ddssec::governance
