// Governance and permissions documents as plain values, each with the line it came from.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "base/protection_kind.hpp"

namespace ddssec::governance {

/// The highest domain id that RTPS's port formula allows (RTPS 9.6.1.1).
inline constexpr DomainId kHighestDomainId = 230;

/// Why other products may read something in another way.
enum class NoteKind : std::uint8_t {
  order,             ///< elements are not in the schema's order
  boolean_spelling,  ///< TRUE, 1
  kind_spelling,     ///< a protection kind not in capitals
  padding,           ///< blanks around a value
  open_range,        ///< an id_range without <min> or <max>
  no_zone,           ///< a time without a zone
  fraction,          ///< a time with a fraction of a second
  no_name,           ///< a grant without a name
  no_default,        ///< a grant without <default>
  refused_spelling,  ///< a value that Fast DDS refuses: blanks around a boolean, 24:00:00
  end_tag_blank,     ///< blanks before the '>' of an end tag
  extension,         ///< elements or attributes that DDS-Security 1.1 does not have
};

/// Something accepted that other products may read in another way; for lint.
struct Note {
  NoteKind kind = NoteKind::order;
  int line = 0;
  std::string path;        ///< of the element, such as /dds/permissions/grant[2]
  std::string text;        ///< the element and what about it
  std::string value = {};  ///< of an element without children, with the blanks around it
  bool operator==(const Note&) const = default;
};

/// An fnmatch expression or another text, and its line.
struct Text {
  std::string text;
  int line = 0;
  bool is_padded = false;  ///< there are blanks around it, which Fast DDS takes for a part of it
  bool operator==(const Text& other) const { return text == other.text; }
};

/// Domain ids from `first` to `last`, both included.
struct DomainRange {
  DomainId first = 0;
  DomainId last = 0;
  /// Written without <max>: Cyclone DDS 0.10.2 and Fast DDS 2.9.1 read `first` alone.
  bool is_open = false;

  /// By what they hold.
  bool operator==(const DomainRange& other) const {
    return first == other.first && last == other.last;
  }
};

/// DomainIdSet, with the domain tags of DDS-Security 1.2.
struct DomainSet {
  std::vector<DomainRange> ranges = {};
  std::vector<Text> tags = {};
  std::vector<Text> tag_expressions = {};
  int line = 0;

  /// True if both the id and the tag are in the set; without tags only the empty tag is
  /// (DDS-Security 1.2 9.4.1.2.4).
  bool contains(DomainId id, std::string_view tag = {}) const;
  /// What Cyclone DDS 0.10.2 and Fast DDS 2.9.1 answer: open ranges are one id, and they do not
  /// read documents with tags.
  bool contains_for_stock(DomainId id) const;
  bool operator==(const DomainSet& other) const {
    return ranges == other.ranges && tags == other.tags && tag_expressions == other.tag_expressions;
  }
};

/// topic_rule of a governance document.
struct TopicRule {
  std::string topic_expression;
  bool is_padded = false;  ///< see Text
  bool enable_discovery_protection = true;
  bool enable_liveliness_protection = true;
  bool enable_read_access_control = true;
  bool enable_write_access_control = true;
  ProtectionKind metadata_protection_kind = ProtectionKind::encrypt;
  /// none, sign or encrypt.
  ProtectionKind data_protection_kind = ProtectionKind::encrypt;
  int line = 0;
};

/// allowed_crypto_algorithms of DDS-Security 1.2: names as in its table of algorithms. Readers fill
/// an absent list with every name of the table; an absent one for the trust chain stays empty and
/// means `digital_signature`.
struct AllowedAlgorithms {
  std::vector<Text> digital_signature = {};
  std::vector<Text> digital_signature_identity_trust_chain = {};
  std::vector<Text> key_establishment = {};
  std::vector<Text> symmetric_cipher = {};
  int line = 0;
};

/// domain_rule of a governance document.
struct DomainRule {
  DomainSet domains = {};
  bool allow_unauthenticated_participants = false;
  bool enable_join_access_control = true;
  bool enable_key_revision = false;
  ProtectionKind discovery_protection_kind = ProtectionKind::encrypt;
  ProtectionKind liveliness_protection_kind = ProtectionKind::encrypt;
  ProtectionKind rtps_protection_kind = ProtectionKind::encrypt;
  /// none, sign or encrypt.
  ProtectionKind rtps_psk_protection_kind = ProtectionKind::none;
  std::vector<TopicRule> topic_rules = {};
  std::optional<AllowedAlgorithms> allowed_algorithms = std::nullopt;
  int line = 0;
};

/// A governance document (DDS-Security 9.4.1.2).
struct Governance {
  std::vector<DomainRule> domain_rules = {};
  std::vector<Note> notes = {};

  /// The first rule whose domains contain the id, or nullptr.
  const DomainRule* find(DomainId id, std::string_view tag = {}) const;
  /// The rule that Cyclone DDS 0.10.2 and Fast DDS 2.9.1 apply; see contains_for_stock.
  const DomainRule* find_for_stock(DomainId id) const;
};

/// A name and value that a data tag of an entity must equal.
struct DataTag {
  std::string name;
  std::string value;
  auto operator<=>(const DataTag&) const = default;
};

/// One publish, subscribe or relay element. All its lists must fit one entity at once.
struct Criteria {
  std::vector<Text> topics = {};
  /// Absent: allow rules take only the partition "", deny rules take any.
  std::optional<std::vector<Text>> partitions = std::nullopt;
  /// Absent: allow rules take only entities without data tags, deny rules take any.
  std::optional<std::vector<DataTag>> data_tags = std::nullopt;
  int line = 0;
};

/// allow_rule or deny_rule.
struct Rule {
  bool allow = false;
  DomainSet domains = {};
  std::vector<Criteria> publish = {};
  std::vector<Criteria> subscribe = {};
  std::vector<Criteria> relay = {};
  int line = 0;
};

/// From not_before on, until just before not_after, UTC.
struct Validity {
  WallTime not_before = {};
  WallTime not_after = {};
  /// False if Cyclone DDS takes not_after for the distant past (DateTime::is_for_cyclone).
  bool is_for_cyclone = true;
  bool contains(WallTime time) const { return not_before <= time && time < not_after; }
  bool operator==(const Validity&) const = default;
};

/// What one subject may do.
struct Grant {
  std::string name = {};
  std::string subject_name = {};
  /// True: the values of subject_name are fnmatch expressions (DDS-Security 1.2).
  bool subject_is_expression = false;
  /// A line break or a tab stands before or after the subject name: Fast DDS takes it for part of
  /// it.
  bool subject_has_line_breaks = false;
  Validity validity = {};
  std::vector<Rule> rules = {};
  bool default_allow = false;
  int line = 0;
};

/// A permissions document (DDS-Security 9.4.1.3).
struct Permissions {
  std::vector<Grant> grants = {};
  std::vector<Note> notes = {};
};

}  // namespace ddssec::governance
