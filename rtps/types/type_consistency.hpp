// Decides whether the types of a writer and a reader are compatible (XTypes 7.2.4), as far as
// discovery shows. It uses TypeInformation, which every vendor announces, and, between participants
// of ddssec, also the minimal TypeObjects.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// The known facts about a type besides its name; both members may be empty.
struct TypeDescription {
  Bytes information = {};  ///< TypeInformation, XCDR2 little-endian (XTypes 7.6.3.2.2)
  /// The minimal TypeObjects of the type and of the types that it contains:
  /// sequence<TypeIdentifierTypeObjectPair>.
  Bytes objects = {};
  bool operator==(const TypeDescription&) const = default;
};

/// Limits in octets; larger ones are neither announced nor stored.
inline constexpr std::size_t kMaxTypeInformation = 1024;
inline constexpr std::size_t kMaxTypeObjects = 6144;

/// Identifies a type in its minimal TypeIdentifier (XTypes 7.3.4.6).
using EquivalenceHash = std::array<std::uint8_t, 14>;
/// Returns the hash, or empty if the octets, which may come from any sender, are not a
/// TypeInformation whose minimal TypeIdentifier has an EquivalenceHash.
std::optional<EquivalenceHash> minimal_hash(BytesView type_information);

enum class TypeVerdict : std::uint8_t {
  unknown,     ///< not enough is known: names decide
  same,        ///< the same minimal type
  assignable,  ///< the reader can read samples of the writer
  different
};
/// Whether a reader can read the type of a writer.
struct TypeJudgement {
  TypeVerdict verdict = TypeVerdict::unknown;
  /// The setting of TYPE_CONSISTENCY_ENFORCEMENT that refuses what its default would allow, for
  /// example "prevent_type_widening = true"; empty if none does.
  std::string_view refused_by = {};
  bool fits() const { return verdict != TypeVerdict::different && refused_by.empty(); }
};
/// Compares the types under the reader's policy. If the answer depends on TypeObjects that are not
/// known, the verdict is unknown. With force_type_validation the types are then refused; otherwise
/// their names decide. (DISALLOW_TYPE_COERCION needs no TypeObjects.)
TypeJudgement judge_types(const TypeDescription& writer, const TypeDescription& reader,
                          const TypeConsistency& policy = {});

/// Returns a text such as "Shape (minimal type 0af3...)".
std::string describe_type(const std::string& name, const TypeDescription& type);

}  // namespace ddssec::rtps
