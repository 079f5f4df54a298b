// Governance and permissions documents as plain values, each with its line in the document.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "base/protection_kind.hpp"

namespace ddssec::governance {

/// The highest domain id that governance and permissions may name (the schemas of
/// DDS-Security 1.2). No participant with security can be in a higher domain.
inline constexpr DomainId kMaxGovernedDomainId = 230;

/// Reasons why other products may read something differently.
enum class NoteKind : std::uint8_t {
  order,              ///< elements are not in the schema's order, and Fast DDS refuses them
  accepted_order,     ///< elements are not in the schema's order, and Fast DDS accepts them
  boolean_spelling,   ///< TRUE, 1
  kind_spelling,      ///< a protection kind not in capitals
  padding,            ///< blanks around a value
  refused_padding,    ///< blanks around a value, for which Fast DDS refuses the document
  no_min,             ///< an id_range without <min>
  no_max,             ///< an id_range without <max>
  no_zone,            ///< a time without a zone, or with one other than UTC
  fraction,           ///< a time with a fraction of a second
  no_name,            ///< a grant without a name
  no_default,         ///< a grant without <default>
  refused_spelling,   ///< a value that Fast DDS refuses, such as 24:00:00
  end_tag_blank,      ///< blanks before the '>' of an end tag
  byte_order_mark,    ///< a mark before the text, with which Cyclone DDS refuses the document
  passed_over,        ///< an unknown element that may be passed over (must_interpret="false")
  newer_element,      ///< an element that DDS-Security 1.1 does not have
  tag_of_rule,        ///< a domain tag in a rule of permissions: Cyclone DDS ignores it
  default_namespace,  ///< the attribute xmlns
  other_attribute,    ///< another attribute that DDS-Security 1.1 does not have
  no_algorithms,      ///< a list of allowed algorithms is absent, and its schema requires it
};

/// True if stock products read another range of domains.
constexpr bool is_open_range(NoteKind kind) {
  return kind == NoteKind::no_min || kind == NoteKind::no_max;
}

/// A construct that is accepted but that other products may read differently; for lint.
struct Note {
  NoteKind kind = NoteKind::order;
  int line = 0;
  std::string path;        ///< path of the element, such as /dds/permissions/grant[2]
  std::string text;        ///< the element and what is special about it
  std::string value = {};  ///< value of an element without children, including surrounding blanks
  std::size_t more = 0;    ///< places of the same text that have no note of their own
  bool operator==(const Note&) const = default;
};

/// An fnmatch expression or another text, and its line.
struct Text {
  std::string text;
  int line = 0;
  bool is_padded = false;  ///< surrounded by blanks, which Fast DDS reads as part of it
  bool operator==(const Text& other) const { return text == other.text; }
};

/// Domain ids from `first` to `last`, both included.
struct DomainRange {
  DomainId first = 0;
  DomainId last = 0;
  /// Written without <max>: Cyclone DDS 0.10.2 and Fast DDS 2.9.1 read only `first`.
  bool is_open = false;

  /// Compares the ids only.
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

  /// True if both the id and the tag are in the set. A set without tags contains the empty tag only
  /// (DDS-Security 1.2, clause 10.4.1.2.5.1).
  bool contains(DomainId id, std::string_view tag = {}) const;
  /// Returns the answer of Cyclone DDS 0.10.2 and Fast DDS 2.9.1: an open range is one id, and they
  /// do not accept documents with tags.
  bool contains_for_stock(DomainId id) const;
  bool operator==(const DomainSet& other) const {
    return ranges == other.ranges && tags == other.tags && tag_expressions == other.tag_expressions;
  }
};

/// One topic_rule of a governance document.
struct TopicRule {
  std::string topic_expression;
  bool is_padded = false;  ///< see Text
  bool enable_discovery_protection = true;
  bool enable_liveliness_protection = true;
  bool enable_read_access_control = true;
  bool enable_write_access_control = true;
  ProtectionKind metadata_protection_kind = ProtectionKind::encrypt;
  /// Only none, sign or encrypt: payloads have no origin authentication.
  ProtectionKind data_protection_kind = ProtectionKind::encrypt;
  int line = 0;
};

/// allowed_crypto_algorithms of DDS-Security 1.2, with the names of its table of algorithms.
/// Readers fill a missing list with all names of the table. A missing list for the trust chain
/// stays empty and means `digital_signature`.
struct AllowedAlgorithms {
  std::vector<Text> digital_signature = {};
  std::vector<Text> digital_signature_identity_trust_chain = {};
  std::vector<Text> key_establishment = {};
  std::vector<Text> symmetric_cipher = {};
  int line = 0;
};

/// One domain_rule of a governance document.
struct DomainRule {
  DomainSet domains = {};
  bool allow_unauthenticated_participants = false;
  bool enable_join_access_control = true;
  bool enable_key_revision = false;
  ProtectionKind discovery_protection_kind = ProtectionKind::encrypt;
  ProtectionKind liveliness_protection_kind = ProtectionKind::encrypt;
  ProtectionKind rtps_protection_kind = ProtectionKind::encrypt;
  /// Only none, sign or encrypt: pre-shared keys have no origin authentication.
  ProtectionKind rtps_psk_protection_kind = ProtectionKind::none;
  std::vector<TopicRule> topic_rules = {};
  std::optional<AllowedAlgorithms> allowed_algorithms = std::nullopt;
  int line = 0;
};

/// A governance document (DDS-Security 1.2, clause 10.4.1.2).
struct Governance {
  std::vector<DomainRule> domain_rules = {};
  /// Counts the documents that were signed one after the other, for running participants; from 1 to
  /// 2^32 - 1. 0 means none. It is written as <?ddssec revision="7"?>, which other products ignore.
  std::uint32_t revision = 0;
  std::vector<Note> notes = {};

  /// Returns the first rule whose domains contain the id, or nullptr.
  const DomainRule* find(DomainId id, std::string_view tag = {}) const;
  /// Returns the rule that Cyclone DDS 0.10.2 and Fast DDS 2.9.1 apply; see contains_for_stock.
  const DomainRule* find_for_stock(DomainId id) const;
};

/// A name and value that a data tag of an entity must equal.
struct DataTag {
  std::string name;
  std::string value;
  auto operator<=>(const DataTag&) const = default;
};

/// One publish, subscribe or relay element. All its lists must match the same entity.
struct Criteria {
  std::vector<Text> topics = {};
  /// Absent: allow rules match only the partition "", deny rules match any.
  std::optional<std::vector<Text>> partitions = std::nullopt;
  /// Absent: allow rules match only entities without data tags, deny rules match any.
  std::optional<std::vector<DataTag>> data_tags = std::nullopt;
  int line = 0;
};

/// One allow_rule or deny_rule.
struct GrantRule {
  bool allow = false;
  DomainSet domains = {};
  std::vector<Criteria> publish = {};
  std::vector<Criteria> subscribe = {};
  std::vector<Criteria> relay = {};
  int line = 0;
};

/// The time from not_before (included) to not_after (excluded), UTC.
struct Validity {
  WallTime not_before = {};
  WallTime not_after = {};
  /// False if Cyclone DDS reads not_after as the distant past
  /// (DateTime::is_read_alike_by_cyclonedds).
  bool is_read_alike_by_cyclonedds = true;
  /// The offsets from UTC that the text has. Fast DDS ignores them (measured with 2.9.1).
  std::chrono::minutes offset_of_not_before = {}, offset_of_not_after = {};
  bool contains(WallTime time) const { return not_before <= time && time < not_after; }
  bool operator==(const Validity&) const = default;
};

/// The permissions of one subject.
struct Grant {
  std::string name = {};
  std::string subject_name = {};
  /// True if the values of subject_name are fnmatch expressions (DDS-Security 1.2).
  bool subject_is_expression = false;
  /// True if a line break or a tab is before or after the subject name. Fast DDS reads it as part
  /// of the name.
  bool subject_has_line_breaks = false;
  Validity validity = {};
  std::vector<GrantRule> rules = {};
  bool default_allow = false;
  int line = 0;
  int default_line = 0;  ///< the line of <default>; 0 without one

  /// Returns the line of <default>; without one, that of the grant.
  int line_of_default() const { return default_line != 0 ? default_line : line; }
};

/// A permissions document (DDS-Security 1.2, clause 10.4.1.5).
struct Permissions {
  std::vector<Grant> grants = {};
  std::vector<Note> notes = {};
};

}  // namespace ddssec::governance
