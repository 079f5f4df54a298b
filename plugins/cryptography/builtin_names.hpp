// What the samples of the builtin writers of discovery and liveliness name.
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

namespace ddssec::cryptography {

/// How the samples of a builtin writer name what they are about.
struct BuiltinTopic {
  EntityId writer;
  std::uint16_t key;  ///< its parameter; 0: ParticipantMessageData, which has none
};
/// Null: the writer is none of discovery or liveliness.
const BuiltinTopic* builtin_topic_of(const EntityId& writer);

/// The participant that sends. Nothing: it is not known, and the message may name any participant.
using Owner = std::optional<GuidPrefix>;

/// A GUID must begin with the prefix of who sends it. Errors: builtin_source_mismatch,
/// builtin_source_unreadable.
Status check_name(const BuiltinTopic& topic, const Owner& owner, std::string_view field,
                  BytesView guid);
std::unexpected<Error> unreadable_name(const BuiltinTopic& topic, std::string_view why);

/// Reads a parameter list with its encapsulation, in pieces of any size, checks each GUID as soon
/// as its prefix is complete, bounds what is costly to Cyclone DDS (locators, of which it compares
/// those of all readers, and partitions), and finds PID_TYPE_INFORMATION. Small, to be copied: who
/// refuses a piece goes on from before it.
class ParameterWalk {
 public:
  /// Of each kind: the same bound as in the embedded participant.
  static constexpr std::size_t kMostLocators = 16;

  /// The next octets. Errors: builtin_source_mismatch, builtin_source_unreadable.
  Status read(const BuiltinTopic& topic, const Owner& owner, BytesView octets);
  /// The list must have ended, and named something. Error: builtin_source_unreadable.
  Status check_end(const BuiltinTopic& topic) const;
  /// Where the parameter id of the type information stands, counted from the encapsulation. Both of
  /// its octets came in one piece.
  std::optional<std::uint32_t> type_information() const { return type_information_; }
  /// Of what the list is about, by the topic's key.
  const EntityId& entity() const { return entity_; }

 private:
  Status take(const BuiltinTopic& topic, const Owner& owner);
  Status begin_list(const BuiltinTopic& topic);
  Status begin_parameter(const BuiltinTopic& topic);
  Status count_locator(const BuiltinTopic& topic);
  Status begin_partitions(const BuiltinTopic& topic);
  /// How many of the octets belong to the partitions.
  Result<std::size_t> read_partitions(const BuiltinTopic& topic, BytesView octets);
  Status note_type_information(const BuiltinTopic& topic);
  std::uint16_t word(std::size_t at) const;

  enum class State : std::uint8_t { encapsulation, header, name, partitions, ended };
  static constexpr std::size_t kHeaderSize = 4;
  static constexpr std::size_t kLocatorKinds = 6;
  static constexpr std::size_t kGuidSize = GuidPrefix::size + EntityId::size;

  State state_ = State::encapsulation;
  bool is_little_ = false;
  bool has_name_ = false;
  bool has_entity_ = false;
  bool has_partitions_ = false;
  std::uint16_t id_ = 0;
  std::uint16_t length_ = 0;
  std::uint32_t to_skip_ = 0;
  std::size_t filled_ = 0;
  std::size_t wanted_ = kHeaderSize;
  std::uint32_t position_ = 0;      ///< octets read
  std::uint32_t piece_begins_ = 0;  ///< position_ before the present piece
  std::optional<std::uint32_t> type_information_ = {};
  EntityId entity_ = {};
  std::array<std::uint8_t, kGuidSize> part_ = {};  ///< what a state waits for
  std::array<std::uint8_t, kLocatorKinds> locators_ = {};
  PartitionWalk partitions_ = {};
};

}  // namespace ddssec::cryptography
