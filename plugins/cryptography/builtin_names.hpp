// The names of participants and endpoints in samples of the builtin writers of discovery and
// liveliness.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/partition_walk.hpp"
#include "plugins/cryptography/type_information.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::cryptography {

/// A builtin writer, and how its samples name their subject.
struct DiscoveryTopic {
  EntityId writer;
  /// The id of the parameter with the key; 0 for ParticipantMessageData, which has none.
  std::uint16_t key;
};
/// Returns the topic of a writer; nullptr if the writer does not belong to discovery or liveliness.
const DiscoveryTopic* discovery_topic_of(const EntityId& writer);

/// The builtin writers of discovery that a local participant does not hear in the clear.
struct ClosedDiscovery {
  /// True if discovery_protection_kind is not NONE: the writers of the secure topics then send
  /// under their own keys.
  bool secure_topics = false;
  /// True if each topic has protected discovery: the other writers then have nothing to send.
  bool clear_topics = false;

  bool includes(const EntityId& writer) const;
};

/// The sending participant. If it is empty, it is not known, and the message may name any
/// participant.
using Owner = std::optional<GuidPrefix>;

/// Success if `guid` begins with the prefix of `owner`. Errors: builtin_source_mismatch,
/// builtin_source_unreadable.
Status check_name(const DiscoveryTopic& topic, const Owner& owner, std::string_view field,
                  BytesView guid);
std::unexpected<Error> unreadable_name_error(const DiscoveryTopic& topic, std::string_view why);

/// True for parameters of RTPS 1 that give an address or a port by itself (RTPS 9.6.3 lists them as
/// deprecated). Cyclone DDS takes them for the beginning of a list of locators that was never
/// created, and crashes when it uses that list's memory. No product in use sends them.
bool is_deprecated_address(std::uint16_t parameter_id);

/// Reads a parameter list with its encapsulation, in pieces of any size. rtps::ParameterReader
/// cannot do that: it needs the whole list, and the host joins the fragments itself. Checks each
/// GUID as soon as its prefix is complete. Limits values that are costly for Cyclone DDS: locators,
/// which it compares with those of all readers, and partitions. Finds PID_TYPE_INFORMATION. The
/// object is small, so that it can be copied: a caller that refuses a piece continues with the copy
/// from before it.
class ParameterWalk {
 public:
  /// The largest number of locators of each kind: the same as in the embedded participant.
  static constexpr std::size_t kMaxLocators = 16;
  /// The largest number of locators of each multicast kind. At each match, a writer of Cyclone DDS
  /// chooses again among those of all its readers. With 16 from each of 2,000 readers it stood
  /// still for 19 seconds.
  static constexpr std::size_t kMaxMulticastLocators = 4;
  /// The number of locators of all kinds together that are free: as many as an endpoint has on an
  /// ordinary machine.
  static constexpr std::size_t kFreeLocators = 4;
  /// The cost of each further locator in the account of announcements. Cyclone DDS walks the
  /// locators of all readers of a topic whenever one of them matches.
  static constexpr std::size_t kOctetsOfLocator = 4096;
  /// The cost of each octet of properties in the account. Cyclone DDS keeps about 100 octets for an
  /// empty property of 16 octets, and about 40 for an empty subscription key of 8 octets.
  static constexpr std::size_t kOctetsOfProperty = 6;
  /// The cost of each partition in the account besides its octets. Cyclone DDS allocates each name
  /// separately.
  static constexpr std::size_t kOctetsOfPartition = 48;

  /// Reads the next octets. Errors: builtin_source_mismatch, builtin_source_unreadable.
  Status read(const DiscoveryTopic& topic, const Owner& owner, BytesView octets);
  /// Success if the list has ended and has named its subject. Error: builtin_source_unreadable.
  Status check_end(const DiscoveryTopic& topic) const;
  /// Returns the place of the type information, counted from the encapsulation. Its octets came in
  /// one piece.
  const TypeInformationAt& type_information() const { return type_information_; }
  /// Returns the cost of a list of that many octets in the account of announcements.
  std::size_t cost(std::size_t octets) const;
  /// True if the list has nothing but names, none of them twice. The end of an endpoint needs
  /// nothing else, and the host might refuse an end with more.
  bool has_only_names() const { return has_only_names_; }
  /// True if the list says by a valid PID_ENDPOINT_SECURITY_INFO (DDS-Security 1.2, clause
  /// 7.5.1.7) how its endpoint is protected. Hosts ask access control about such endpoints only.
  bool says_protection() const { return security_infos_ == 1 && is_security_info_valid_; }
  /// Returns the entity id of the list's subject, from the topic's key.
  const EntityId& entity() const { return entity_; }

 private:
  Status read_filled(const DiscoveryTopic& topic, const Owner& owner);
  Status begin_list(const DiscoveryTopic& topic);
  Status begin_parameter(const DiscoveryTopic& topic);
  void note_name(const DiscoveryTopic& topic);
  Status count_locator(const DiscoveryTopic& topic);
  bool begin_security_info();
  Status begin_partitions(const DiscoveryTopic& topic);
  /// Reads the partitions in the next octets. Returns the number of octets that belong to them.
  Result<std::size_t> read_partitions(const DiscoveryTopic& topic, BytesView octets);
  /// Notes the place of type information. `header` is the position of the parameter's first octet.
  Status note_type_information(const DiscoveryTopic& topic, std::uint32_t header);
  /// Returns the id of the parameter of whose header at least the id has arrived.
  std::uint16_t arriving_id() const;

  enum class State : std::uint8_t {
    encapsulation,
    header,
    name,
    partitions,
    security_info,
    ended,
  };
  static constexpr std::size_t kHeaderSize = rtps::ParameterHeader::size;
  static constexpr std::size_t kLocatorKinds = 6;
  static constexpr std::size_t kGuidSize = GuidPrefix::size + EntityId::size;

  State state_ = State::encapsulation;
  bool is_little_ = false;
  bool has_name_ = false;
  bool has_entity_ = false;
  bool has_only_names_ = true;
  bool has_partitions_ = false;
  bool is_security_info_valid_ = false;
  std::uint8_t security_infos_ = 0;  ///< counted up to 2
  std::uint8_t names_ = 0;           ///< bits by index in kNames
  std::uint16_t id_ = 0;
  std::uint16_t length_ = 0;
  std::uint32_t to_skip_ = 0;
  std::size_t filled_ = 0;
  std::size_t wanted_ = kHeaderSize;
  std::uint32_t position_ = 0;      ///< octets read
  std::uint32_t piece_begins_ = 0;  ///< position_ before the present piece
  TypeInformationAt type_information_ = {};
  std::uint32_t type_information_header_ = 0;
  EntityId entity_ = {};
  std::array<std::uint8_t, kGuidSize> part_ = {};  ///< the octets that the present state collects
  std::array<std::uint8_t, kLocatorKinds> locators_ = {};
  PartitionWalk partitions_ = {};
  std::uint32_t properties_ = 0;  ///< octets of PID_PROPERTY_LIST and of subscription keys
};

}  // namespace ddssec::cryptography
