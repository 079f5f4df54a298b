#include "plugins/cryptography/builtin_names.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "base/reader.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

// The bits that mark parameters of vendors, and those that must be understood. Hosts may ignore
// these bits.
constexpr std::uint16_t kFlags = pid::kMustUnderstand | pid::kVendorSpecific;

constexpr std::array kTopics = {
    DiscoveryTopic{rtps::kSpdpWriter, pid::kParticipantGuid},
    DiscoveryTopic{rtps::kParticipantsSecureWriter, pid::kParticipantGuid},
    DiscoveryTopic{rtps::kPublicationsWriter, pid::kEndpointGuid},
    DiscoveryTopic{rtps::kPublicationsSecureWriter, pid::kEndpointGuid},
    DiscoveryTopic{rtps::kSubscriptionsWriter, pid::kEndpointGuid},
    DiscoveryTopic{rtps::kSubscriptionsSecureWriter, pid::kEndpointGuid},
    DiscoveryTopic{rtps::kTopicsWriter, pid::kCycloneTopicGuid},
    DiscoveryTopic{rtps::kParticipantMessageWriter, 0},
    DiscoveryTopic{rtps::kParticipantMessageSecureWriter, 0},
};

// The kinds of locators, of which an announcement may have several (RTPS 9.6.3).
struct LocatorKind {
  std::uint16_t id;
  const char* name;
  bool is_multicast = false;
};
constexpr std::array kLocators = {
    LocatorKind{pid::kUnicastLocator, "PID_UNICAST_LOCATOR"},
    LocatorKind{pid::kMulticastLocator, "PID_MULTICAST_LOCATOR", true},
    LocatorKind{pid::kDefaultUnicastLocator, "PID_DEFAULT_UNICAST_LOCATOR"},
    LocatorKind{pid::kDefaultMulticastLocator, "PID_DEFAULT_MULTICAST_LOCATOR", true},
    LocatorKind{pid::kMetatrafficUnicastLocator, "PID_METATRAFFIC_UNICAST_LOCATOR"},
    LocatorKind{pid::kMetatrafficMulticastLocator, "PID_METATRAFFIC_MULTICAST_LOCATOR", true}};

// The parameters PID_METATRAFFIC_MULTICAST_IPADDRESS, PID_DEFAULT_UNICAST_IPADDRESS,
// PID_METATRAFFIC_UNICAST_PORT, PID_DEFAULT_UNICAST_PORT, PID_MULTICAST_IPADDRESS,
// PID_METATRAFFIC_UNICAST_IPADDRESS, PID_METATRAFFIC_MULTICAST_PORT.
constexpr std::array<std::uint16_t, 7> kDeprecatedAddresses = {0x000b, 0x000c, 0x000d, 0x000e,
                                                               0x0011, 0x0045, 0x0046};

// The size of EndpointSecurityAttributesMask.
constexpr std::size_t kSecurityMaskSize = 4;

constexpr std::string_view kDocument = "a discovery or liveliness message";

// A parameter that contains a GUID.
struct NamingParameter {
  std::uint16_t id;
  const char* name;
};
constexpr std::array kNames = {NamingParameter{pid::kParticipantGuid, "PID_PARTICIPANT_GUID"},
                               NamingParameter{pid::kEndpointGuid, "PID_ENDPOINT_GUID"},
                               NamingParameter{pid::kKeyHash, "PID_KEY_HASH"},
                               NamingParameter{pid::kCycloneTopicGuid, "PID_CYCLONE_TOPIC_GUID"}};

// Returns the index in kNames; empty if the parameter names nothing in samples of this topic.
std::optional<std::size_t> name_of(const DiscoveryTopic& topic, std::uint16_t id) {
  const auto found = std::ranges::find(kNames, id, &NamingParameter::id);
  if (found == kNames.end()) return std::nullopt;
  if (id == pid::kCycloneTopicGuid && id != topic.key) return std::nullopt;
  return static_cast<std::size_t>(found - kNames.begin());
}

}  // namespace

const DiscoveryTopic* discovery_topic_of(const EntityId& writer) {
  constexpr std::uint8_t kBuiltinKeyedWriter = 0xc2;
  if (writer.octets[3] != kBuiltinKeyedWriter) return nullptr;
  const auto found = std::ranges::find(kTopics, writer, &DiscoveryTopic::writer);
  return found == kTopics.end() ? nullptr : &*found;
}

bool ClosedDiscovery::includes(const EntityId& writer) const {
  const auto* const topic = discovery_topic_of(writer);
  if (topic == nullptr || topic->key == 0 || writer == rtps::kSpdpWriter) return false;
  constexpr std::uint8_t kSecure = 0xff;
  return writer.octets[0] == kSecure ? secure_topics : clear_topics;
}

bool is_deprecated_address(std::uint16_t parameter_id) {
  return std::ranges::find(kDeprecatedAddresses, parameter_id) != kDeprecatedAddresses.end();
}

Status check_name(const DiscoveryTopic& topic, const Owner& owner, std::string_view field,
                  BytesView guid) {
  if (guid.size() < GuidPrefix::size) return unreadable_name_error(topic, "a GUID is too short");
  const auto found = GuidPrefix::from(guid.first(GuidPrefix::size));
  if (!owner || found == *owner) return {};
  return fail(Code::builtin_source_mismatch, {.document = std::string(kDocument),
                                              .field = std::string(field),
                                              .expected = owner->to_string(),
                                              .found = found.to_string(),
                                              .note = "by writer " + topic.writer.to_string()});
}

std::unexpected<Error> unreadable_name_error(const DiscoveryTopic& topic, std::string_view why) {
  return fail(Code::builtin_source_unreadable,
              {.document = std::string(kDocument),
               .note = std::string(why) + ", by writer " + topic.writer.to_string()});
}

Status ParameterWalk::read(const DiscoveryTopic& topic, const Owner& owner, BytesView octets) {
  piece_begins_ = position_;
  while (state_ != State::ended && !octets.empty()) {
    if (state_ == State::partitions) {
      DDSSEC_ASSIGN_OR_RETURN(const auto partitions, read_partitions(topic, octets));
      octets = octets.subspan(partitions);
      continue;
    }
    const auto skipped = std::min<std::size_t>(to_skip_, octets.size());
    to_skip_ -= static_cast<std::uint32_t>(skipped);
    octets = octets.subspan(skipped);
    const auto taken = std::min(wanted_ - filled_, octets.size());
    std::copy_n(octets.begin(), taken, part_.begin() + static_cast<std::ptrdiff_t>(filled_));
    octets = octets.subspan(taken);
    filled_ += taken;
    position_ += static_cast<std::uint32_t>(skipped + taken);
    if (filled_ == wanted_) DDSSEC_RETURN_IF_ERROR(read_filled(topic, owner));
  }
  // The host gets this piece before the rest of the header has come.
  if (state_ == State::header && filled_ >= sizeof(id_) && arriving_id() == pid::kTypeInformation)
    return note_type_information(topic, position_ - static_cast<std::uint32_t>(filled_));
  return {};
}

Status ParameterWalk::check_end(const DiscoveryTopic& topic) const {
  if (state_ == State::encapsulation) return unreadable_name_error(topic, "it is too short");
  if (state_ != State::ended)
    return unreadable_name_error(topic, "its parameters have lengths that lie");
  return has_name_ ? Status() : unreadable_name_error(topic, "it names nothing");
}

std::size_t ParameterWalk::cost(std::size_t octets) const {
  const auto locators = std::accumulate(locators_.begin(), locators_.end(), std::size_t{0});
  const auto properties = (kOctetsOfProperty - 1) * properties_;
  return octets + properties + kOctetsOfPartition * partitions_.names() +
         kOctetsOfLocator * (std::max(locators, kFreeLocators) - kFreeLocators);
}

Status ParameterWalk::read_filled(const DiscoveryTopic& topic, const Owner& owner) {
  filled_ = 0;
  wanted_ = kHeaderSize;
  if (state_ == State::encapsulation) return begin_list(topic);
  if (state_ == State::header) return begin_parameter(topic);
  if (state_ == State::security_info) {
    constexpr std::uint8_t kIsValid = 0x80;
    is_security_info_valid_ = (part_[is_little_ ? 3 : 0] & kIsValid) != 0;
    state_ = State::header;
    to_skip_ = length_ - static_cast<std::uint32_t>(kSecurityMaskSize);
    return {};
  }
  state_ = State::header;
  to_skip_ = length_ - static_cast<std::uint32_t>(kGuidSize);
  has_name_ = true;
  DDSSEC_RETURN_IF_ERROR(check_name(topic, owner, kNames.at(*name_of(topic, id_)).name, part_));
  if (id_ != topic.key) return {};
  if (has_entity_) return unreadable_name_error(topic, "it names two endpoints");
  has_entity_ = true;
  entity_ = EntityId::from(BytesView(part_).subspan(GuidPrefix::size));
  return {};
}

Status ParameterWalk::begin_list(const DiscoveryTopic& topic) {
  constexpr std::uint8_t kBig = 2, kLittle = 3;
  if (part_[0] != 0 || (part_[1] != kBig && part_[1] != kLittle))
    return unreadable_name_error(topic, "its encapsulation is not a parameter list");
  is_little_ = part_[1] == kLittle;
  state_ = State::header;
  return {};
}

Status ParameterWalk::begin_parameter(const DiscoveryTopic& topic) {
  Reader in(BytesView(part_).first(kHeaderSize), is_little_ ? Endian::little : Endian::big);
  const auto header = rtps::read_parameter_header(in);
  if (!header) return unreadable_name_error(topic, "its parameters have lengths that lie");
  if (header->is_sentinel()) {
    state_ = State::ended;
    return {};
  }
  id_ = header->id;
  length_ = header->length;
  note_name(topic);
  if (is_deprecated_address(id_))
    return unreadable_name_error(topic, "it has an address in the form of RTPS 1");
  if (id_ == pid::kTypeInformation)
    DDSSEC_RETURN_IF_ERROR(
        note_type_information(topic, position_ - static_cast<std::uint32_t>(kHeaderSize)));
  if (id_ == pid::kPartition) return begin_partitions(topic);
  DDSSEC_RETURN_IF_ERROR(count_locator(topic));
  if (id_ == pid::kPropertyList || id_ == pid::kAdlinkSubscriptionKeys) properties_ += length_;
  if (begin_security_info()) return {};
  if (!name_of(topic, id_)) {
    to_skip_ = length_;
    return {};
  }
  if (length_ < kGuidSize) return unreadable_name_error(topic, "a GUID is too short");
  state_ = State::name;
  wanted_ = kGuidSize;
  return {};
}

// Begins a parameter about security. Returns true if its first octets are read next.
bool ParameterWalk::begin_security_info() {
  if ((id_ & ~kFlags) != pid::kEndpointSecurityInfo) return false;
  security_infos_ = security_infos_ == 0 ? 1 : 2;
  if (id_ != pid::kEndpointSecurityInfo || length_ < kSecurityMaskSize) return false;
  state_ = State::security_info;
  wanted_ = kSecurityMaskSize;
  return true;
}

void ParameterWalk::note_name(const DiscoveryTopic& topic) {
  const auto name = name_of(topic, id_);
  const auto bit = static_cast<std::uint8_t>(name ? 1u << *name : 0u);
  if (!name || length_ != kGuidSize || (names_ & bit) != 0) has_only_names_ = false;
  names_ |= bit;
}

Status ParameterWalk::count_locator(const DiscoveryTopic& topic) {
  static_assert(kLocators.size() == kLocatorKinds);
  const auto kind = std::ranges::find(kLocators, id_, &LocatorKind::id);
  if (kind == kLocators.end()) return {};
  const auto most = kind->is_multicast ? kMaxMulticastLocators : kMaxLocators;
  auto& count = locators_[static_cast<std::size_t>(kind - kLocators.begin())];
  if (++count <= most) return {};
  return unreadable_name_error(topic,
                               "it has more than " + std::to_string(most) + ' ' + kind->name);
}

Status ParameterWalk::begin_partitions(const DiscoveryTopic& topic) {
  if (has_partitions_) return unreadable_name_error(topic, "its partitions come twice");
  if (length_ == 0) return unreadable_name_error(topic, "its partitions have lengths that lie");
  has_partitions_ = true;
  state_ = State::partitions;
  partitions_ = PartitionWalk(length_, is_little_);
  return {};
}

Result<std::size_t> ParameterWalk::read_partitions(const DiscoveryTopic& topic, BytesView octets) {
  const auto part = octets.first(std::min(partitions_.rest(), octets.size()));
  DDSSEC_RETURN_IF_ERROR(partitions_.read(topic, part));
  position_ += static_cast<std::uint32_t>(part.size());
  if (partitions_.rest() == 0) state_ = State::header;
  return part.size();
}

Status ParameterWalk::note_type_information(const DiscoveryTopic& topic, std::uint32_t header) {
  if (type_information_)
    return header == type_information_header_
               ? Status()
               : unreadable_name_error(topic, "its type information comes twice");
  type_information_header_ = header;
  // If the host already has the first octet of the id, the second octet is changed so that the id
  // becomes one that does not exist: 0x8075 of a vendor, or PID_PAD.
  constexpr std::uint8_t kOfVendor = 0x80;
  if (header >= piece_begins_)
    type_information_ = {.at = header};
  else
    type_information_ = {
        .at = header + 1, .octets = 1, .value = is_little_ ? kOfVendor : std::uint8_t{0}};
  return {};
}

std::uint16_t ParameterWalk::arriving_id() const {
  const auto high = part_[is_little_ ? 1 : 0], low = part_[is_little_ ? 0 : 1];
  return static_cast<std::uint16_t>(high << 8 | low);
}

}  // namespace ddssec::cryptography
