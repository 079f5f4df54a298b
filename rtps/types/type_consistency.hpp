// Whether the types of a writer and a reader fit each other (XTypes 7.2.4), as far as discovery
// tells: by TypeInformation, which every vendor announces, and between participants of ours by the
// minimal TypeObjects themselves.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// What is known of a type besides its name; both may be empty.
struct TypeDescription {
  Bytes information = {};  ///< TypeInformation, XCDR2 little-endian (XTypes 7.6.3.2.2)
  /// The minimal TypeObjects of it and of what it contains: sequence<TypeIdentifierTypeObjectPair>.
  Bytes objects = {};
  bool operator==(const TypeDescription&) const = default;
};

/// More is neither announced nor stored.
inline constexpr std::size_t kMostTypeInformation = 1024;
inline constexpr std::size_t kMostTypeObjects = 6144;

/// What names a type in its minimal TypeIdentifier (XTypes 7.3.4.6).
using EquivalenceHash = std::array<std::uint8_t, 14>;
/// Nothing if the octets, from any sender, are no TypeInformation with such a hash.
std::optional<EquivalenceHash> minimal_hash(BytesView type_information);

enum class TypeVerdict : std::uint8_t {
  unknown,     ///< not enough is known: names decide
  same,        ///< the same minimal type
  assignable,  ///< samples of the writer can be read as the reader's
  different
};
struct TypeJudgement {
  TypeVerdict verdict = TypeVerdict::unknown;
  /// The setting of TYPE_CONSISTENCY_ENFORCEMENT that refuses what its default would allow, such as
  /// "prevent_type_widening = true"; empty: none.
  std::string_view refused_by = {};
  bool fits() const { return verdict != TypeVerdict::different && refused_by.empty(); }
};
/// Under the reader's policy. What only the TypeObjects tell, and those are not known, is unknown:
/// refused with force_type_validation, else names decide. (DISALLOW_TYPE_COERCION needs none.)
TypeJudgement judge_types(const TypeDescription& writer, const TypeDescription& reader,
                          const TypeConsistency& policy = {});

/// "Shape (minimal type 0af3...)".
std::string describe_type(const std::string& name, const TypeDescription& type);

}  // namespace ddssec::rtps
