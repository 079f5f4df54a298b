#include "rtps/types/type_consistency.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/reader.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kMinimal = 0xf1, kStructure = 0x51, kString8Small = 0x70,
                       kString8Large = 0x71, kSequenceSmall = 0x80, kSequenceLarge = 0x81;
constexpr std::uint32_t kMinimalMember = 0x1001;
constexpr std::uint16_t kFinal = 1, kExtensibility = 7;
constexpr std::uint16_t kOptional = 0x08, kKey = 0x20;
constexpr int kMaxTypeDepth = 16;

Status align(Reader& reader) { return reader.skip(-reader.position() & 3u); }

Result<BytesView> read_delimited(Reader& reader) {
  DDSSEC_RETURN_IF_ERROR(align(reader));
  DDSSEC_ASSIGN_OR_RETURN(const auto size, reader.read<std::uint32_t>());
  return reader.read_bytes(size);
}

std::optional<EquivalenceHash> hash_in(BytesView type_identifier) {
  EquivalenceHash hash{};
  if (type_identifier.size() != 1 + hash.size() || type_identifier[0] != kMinimal)
    return std::nullopt;
  std::ranges::copy(type_identifier.subspan(1), hash.begin());
  return hash;
}

// Reads a member of a mutable type, whose length is in the header (XTypes 7.4.3.4.2).
Result<BytesView> read_member(Reader& reader, std::uint32_t header) {
  const auto length_code = header >> 28 & 7;
  if (length_code < 4) return reader.read_bytes(std::size_t{1} << length_code);
  if (length_code > 4) return fail(Code::malformed);
  DDSSEC_ASSIGN_OR_RETURN(const auto size, reader.read<std::uint32_t>());
  return reader.read_bytes(size);
}

Result<EquivalenceHash> read_minimal_hash(BytesView type_information) {
  Reader outer(type_information, Endian::little);
  DDSSEC_ASSIGN_OR_RETURN(const auto delimited, read_delimited(outer));
  Reader members(delimited, Endian::little);
  while (members.remaining() > 0) {
    DDSSEC_RETURN_IF_ERROR(align(members));
    DDSSEC_ASSIGN_OR_RETURN(const auto header, members.read<std::uint32_t>());
    DDSSEC_ASSIGN_OR_RETURN(const auto member, read_member(members, header));
    if ((header & 0x0fffffff) != kMinimalMember) continue;
    Reader with_dependencies(member, Endian::little);
    DDSSEC_ASSIGN_OR_RETURN(const auto inner, read_delimited(with_dependencies));
    Reader with_size(inner, Endian::little);
    DDSSEC_ASSIGN_OR_RETURN(const auto identifier, read_delimited(with_size));
    const auto hash = hash_in(identifier.first(std::min<std::size_t>(identifier.size(), 15)));
    if (hash) return *hash;
  }
  return fail(Code::malformed);
}

struct Member {
  std::uint32_t id = 0;
  std::uint16_t flags = 0;
  Reader type{BytesView()};  // positioned at its TypeIdentifier
  BytesView name_hash = {};
};
struct Structure {
  std::uint16_t flags = 0;
  std::vector<Member> members = {};
};
using Structures = std::map<EquivalenceHash, Structure>;

// Reads a CommonStructMember and the hash of its name (XTypes Annex B).
Result<Member> read_struct_member(BytesView octets) {
  Reader reader(octets, Endian::little);
  Member out;
  DDSSEC_ASSIGN_OR_RETURN(out.id, reader.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(out.flags, reader.read<std::uint16_t>());
  if (reader.remaining() < 5) return fail(Code::truncated);
  const auto end = octets.size() - 4;
  out.type = Reader(octets.first(end), Endian::little);
  DDSSEC_RETURN_IF_ERROR(out.type.skip(reader.position()));
  out.name_hash = octets.subspan(end);
  return out;
}

// Returns empty for a TypeObject of another kind.
Result<std::optional<Structure>> read_structure(BytesView object) {
  Reader reader(object, Endian::little);
  DDSSEC_ASSIGN_OR_RETURN(const auto octet, reader.read<std::uint8_t>());
  if (octet != kMinimal) return fail(Code::malformed);
  DDSSEC_ASSIGN_OR_RETURN(const auto value, reader.read<std::uint8_t>());
  if (value != kStructure) return std::optional<Structure>();
  Structure out;
  DDSSEC_ASSIGN_OR_RETURN(out.flags, reader.read<std::uint16_t>());
  // The base type is skipped: either there is none, or it makes the hash different.
  DDSSEC_RETURN_IF_ERROR(read_delimited(reader));
  DDSSEC_RETURN_IF_ERROR(align(reader));
  DDSSEC_RETURN_IF_ERROR(reader.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read<std::uint32_t>());
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto delimited, read_delimited(reader));
    DDSSEC_ASSIGN_OR_RETURN(auto struct_member, read_struct_member(delimited));
    out.members.push_back(std::move(struct_member));
  }
  return out;
}

Result<Structures> read_objects(BytesView octets) {
  if (octets.size() > kMaxTypeObjects) return fail(Code::length_out_of_range);
  Structures out;
  Reader reader(octets, Endian::little);
  DDSSEC_RETURN_IF_ERROR(reader.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read<std::uint32_t>());
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(const auto bytes, reader.read_bytes(1 + sizeof(EquivalenceHash)));
    const auto hash = hash_in(bytes);
    DDSSEC_ASSIGN_OR_RETURN(const auto delimited, read_delimited(reader));
    DDSSEC_ASSIGN_OR_RETURN(auto structure, read_structure(delimited));
    if (hash && structure) out[*hash] = std::move(*structure);
  }
  return out;
}

bool is_string(std::uint8_t kind) { return kind == kString8Small || kind == kString8Large; }
bool is_sequence(std::uint8_t kind) { return kind == kSequenceSmall || kind == kSequenceLarge; }

// Returns 0 if there is no bound.
Result<std::uint32_t> read_bound(Reader& type, std::uint8_t kind) {
  if (kind == kString8Large || kind == kSequenceLarge) return type.read_aligned<std::uint32_t>();
  DDSSEC_ASSIGN_OR_RETURN(const auto octet, type.read<std::uint8_t>());
  return octet;
}

Status skip_collection_header(Reader& type) {
  DDSSEC_RETURN_IF_ERROR(type.read<std::uint8_t>());
  DDSSEC_RETURN_IF_ERROR(type.read_aligned<std::uint16_t>());
  return {};
}

// Decides whether a reader's type can take samples of a writer's type (XTypes 7.2.4.4).
class Comparison {
 public:
  Comparison(const Structures& writer, const Structures& reader, const TypeConsistency& policy)
      : writer_(writer), reader_(reader), policy_(policy) {}

  bool assignable(const EquivalenceHash& writer, const EquivalenceHash& reader, int depth = 0) {
    if (writer == reader || assignable_.contains({writer, reader})) return true;
    const auto from = writer_.find(writer);
    const auto to = reader_.find(reader);
    const bool out = depth < kMaxTypeDepth && from != writer_.end() && to != reader_.end() &&
                     assignable(from->second, to->second, depth);
    if (out) assignable_.emplace(writer, reader);
    return out;
  }
  std::string_view refused_by() const { return refused_by_; }

 private:
  // The additional members at the end of an appendable type must not be keys.
  bool assignable(const Structure& from, const Structure& to, int depth) {
    if ((from.flags & kExtensibility) != (to.flags & kExtensibility)) return false;
    const auto common = std::min(from.members.size(), to.members.size());
    const bool as_long = from.members.size() == to.members.size();
    if ((from.flags & kFinal) != 0 && !as_long) return false;
    for (std::size_t i = 0; i < common; ++i)
      if (!assignable(from.members[i], to.members[i], depth)) return false;
    const auto& longer = from.members.size() > common ? from.members : to.members;
    const auto is_key = [](const Member& m) { return (m.flags & kKey) != 0; };
    if (common == 0 ||
        std::any_of(longer.begin() + static_cast<std::ptrdiff_t>(common), longer.end(), is_key))
      return false;
    return from.members.size() == common ||
           allowed(!policy_.prevent_type_widening, "prevent_type_widening = true");
  }

  bool assignable(const Member& from, const Member& to, int depth) {
    constexpr std::uint16_t kCounts = kOptional | kKey;
    return from.id == to.id && (from.flags & kCounts) == (to.flags & kCounts) &&
           (policy_.ignore_member_names || std::ranges::equal(from.name_hash, to.name_hash)) &&
           assignable(from.type, to.type, depth).value_or(false);
  }

  Result<bool> assignable(Reader from, Reader to, int depth) {
    if (std::ranges::equal(from.rest(), to.rest())) return true;
    DDSSEC_ASSIGN_OR_RETURN(const auto flat, assignable_but_for_bounds(from, to, depth));
    if (flat) return *flat;
    const auto writer = hash_in(from.rest()), reader = hash_in(to.rest());
    return writer && reader && assignable(*writer, *reader, depth + 1);
  }

  // Handles strings, and sequences of equal types or of such sequences; returns empty for other
  // types.
  Result<std::optional<bool>> assignable_but_for_bounds(Reader from, Reader to, int depth) {
    DDSSEC_ASSIGN_OR_RETURN(const auto written, from.read<std::uint8_t>());
    DDSSEC_ASSIGN_OR_RETURN(const auto read, to.read<std::uint8_t>());
    if (is_string(written) && is_string(read)) {
      DDSSEC_ASSIGN_OR_RETURN(const auto bound, read_bound(from, written));
      DDSSEC_ASSIGN_OR_RETURN(const auto room, read_bound(to, read));
      return fits(bound, room) ||
             allowed(policy_.ignore_string_bounds, "ignore_string_bounds = false");
    }
    if (!is_sequence(written) || !is_sequence(read)) return std::optional<bool>();
    DDSSEC_RETURN_IF_ERROR(skip_collection_header(from));
    DDSSEC_RETURN_IF_ERROR(skip_collection_header(to));
    DDSSEC_ASSIGN_OR_RETURN(const auto bound, read_bound(from, written));
    DDSSEC_ASSIGN_OR_RETURN(const auto room, read_bound(to, read));
    const bool same = std::ranges::equal(from.rest(), to.rest());
    if (!same) {
      if (depth >= kMaxTypeDepth) return false;
      DDSSEC_ASSIGN_OR_RETURN(const auto elements, assignable_but_for_bounds(from, to, depth + 1));
      if (!elements.value_or(false)) return false;
    }
    return fits(bound, room) ||
           allowed(policy_.ignore_sequence_bounds, "ignore_sequence_bounds = false");
  }

  static bool fits(std::uint32_t bound, std::uint32_t room) {
    return room == 0 || (bound != 0 && bound <= room);
  }
  bool allowed(bool is_allowed, std::string_view setting) {
    if (!is_allowed) refused_by_ = setting;
    return is_allowed;
  }

  const Structures& writer_;
  const Structures& reader_;
  const TypeConsistency& policy_;
  std::string_view refused_by_;
  // The pairs that were found assignable. Each is compared once, however often the types contain
  // it: otherwise small TypeObjects that contain each other often take years to compare. The first
  // pair that is not assignable ends the comparison.
  std::set<std::pair<EquivalenceHash, EquivalenceHash>> assignable_;
};

TypeJudgement unknown(const TypeConsistency& policy) {
  return {TypeVerdict::unknown,
          policy.force_type_validation ? std::string_view("force_type_validation = true") : ""};
}

}  // namespace

std::optional<EquivalenceHash> minimal_hash(BytesView type_information) {
  const auto hash = read_minimal_hash(type_information);
  return hash ? std::optional(*hash) : std::nullopt;
}

TypeJudgement judge_types(const TypeDescription& writer, const TypeDescription& reader,
                          const TypeConsistency& policy) {
  const auto from = minimal_hash(writer.information), to = minimal_hash(reader.information);
  if (!from || !to) return unknown(policy);
  if (*from == *to) return {TypeVerdict::same};
  if (policy.kind == TypeConsistencyKind::disallow_type_coercion)
    return {TypeVerdict::different, "kind = DISALLOW_TYPE_COERCION"};
  const auto writers = read_objects(writer.objects), readers = read_objects(reader.objects);
  if (!writers || !readers || !writers->contains(*from) || !readers->contains(*to))
    return unknown(policy);
  Comparison comparison(*writers, *readers, policy);
  if (comparison.assignable(*from, *to)) return {TypeVerdict::assignable};
  return {TypeVerdict::different, comparison.refused_by()};
}

std::string describe_type(const std::string& name, const TypeDescription& type) {
  const auto hash = minimal_hash(type.information);
  return hash ? name + " (minimal type " + to_hex(*hash) + ")" : name;
}

}  // namespace ddssec::rtps
