#include "rtps/types/type_consistency.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include "base/reader.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::uint8_t kMinimal = 0xf1, kStructure = 0x51, kString8Small = 0x70,
                       kString8Large = 0x71;
constexpr std::uint32_t kMinimalMember = 0x1001;
constexpr std::uint16_t kFinal = 1, kExtensibility = 7;
constexpr std::uint16_t kOptional = 0x08, kKey = 0x20;
constexpr int kDeepest = 16;

Status align(Reader& reader) { return reader.skip(-reader.position() & 3u); }

Result<BytesView> read_delimited(Reader& reader) {
  DDSSEC_TRY(align(reader));
  return reader.read_bytes(DDSSEC_TRY(reader.read<std::uint32_t>()));
}

std::optional<EquivalenceHash> hash_in(BytesView type_identifier) {
  EquivalenceHash hash{};
  if (type_identifier.size() != 1 + hash.size() || type_identifier[0] != kMinimal)
    return std::nullopt;
  std::ranges::copy(type_identifier.subspan(1), hash.begin());
  return hash;
}

// XTypes 7.4.3.4.2: how long a member of a mutable type is.
Result<BytesView> read_member(Reader& reader, std::uint32_t header) {
  const auto length_code = header >> 28 & 7;
  if (length_code < 4) return reader.read_bytes(std::size_t{1} << length_code);
  if (length_code > 4) return fail(Code::malformed);
  return reader.read_bytes(DDSSEC_TRY(reader.read<std::uint32_t>()));
}

Result<EquivalenceHash> read_minimal_hash(BytesView type_information) {
  Reader outer(type_information, Endian::little);
  Reader members(DDSSEC_TRY(read_delimited(outer)), Endian::little);
  while (members.remaining() > 0) {
    DDSSEC_TRY(align(members));
    const auto header = DDSSEC_TRY(members.read<std::uint32_t>());
    const auto member = DDSSEC_TRY(read_member(members, header));
    if ((header & 0x0fffffff) != kMinimalMember) continue;
    Reader with_dependencies(member, Endian::little);
    Reader with_size(DDSSEC_TRY(read_delimited(with_dependencies)), Endian::little);
    const auto identifier = DDSSEC_TRY(read_delimited(with_size));
    const auto hash = hash_in(identifier.first(std::min<std::size_t>(identifier.size(), 15)));
    if (hash) return *hash;
  }
  return fail(Code::malformed);
}

struct Member {
  std::uint32_t id = 0;
  std::uint16_t flags = 0;
  BytesView type = {}, name_hash = {};
};
struct Structure {
  std::uint16_t flags = 0;
  std::vector<Member> members = {};
};
using Structures = std::map<EquivalenceHash, Structure>;

// CommonStructMember and the hash of its name (XTypes Annex B).
Result<Member> read_struct_member(BytesView octets) {
  Reader reader(octets, Endian::little);
  Member out;
  out.id = DDSSEC_TRY(reader.read<std::uint32_t>());
  out.flags = DDSSEC_TRY(reader.read<std::uint16_t>());
  if (reader.remaining() < 5) return fail(Code::truncated);
  out.type = DDSSEC_TRY(reader.read_bytes(reader.remaining() - 4));
  out.name_hash = reader.rest();
  return out;
}

// Nothing for a TypeObject of another kind.
Result<std::optional<Structure>> read_structure(BytesView object) {
  Reader reader(object, Endian::little);
  if (DDSSEC_TRY(reader.read<std::uint8_t>()) != kMinimal) return fail(Code::malformed);
  if (DDSSEC_TRY(reader.read<std::uint8_t>()) != kStructure) return std::optional<Structure>();
  Structure out;
  out.flags = DDSSEC_TRY(reader.read<std::uint16_t>());
  DDSSEC_TRY(read_delimited(reader));  // the base type: none, or it makes the hash different
  DDSSEC_TRY(align(reader));
  DDSSEC_TRY(reader.read<std::uint32_t>());
  const auto count = DDSSEC_TRY(reader.read<std::uint32_t>());
  for (std::uint32_t i = 0; i < count; ++i)
    out.members.push_back(DDSSEC_TRY(read_struct_member(DDSSEC_TRY(read_delimited(reader)))));
  return out;
}

Result<Structures> read_objects(BytesView octets) {
  if (octets.size() > kMostTypeObjects) return fail(Code::length_out_of_range);
  Structures out;
  Reader reader(octets, Endian::little);
  DDSSEC_TRY(reader.read<std::uint32_t>());
  const auto count = DDSSEC_TRY(reader.read<std::uint32_t>());
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto hash = hash_in(DDSSEC_TRY(reader.read_bytes(1 + sizeof(EquivalenceHash))));
    auto structure = DDSSEC_TRY(read_structure(DDSSEC_TRY(read_delimited(reader))));
    if (hash && structure) out[*hash] = std::move(*structure);
  }
  return out;
}

bool is_string(BytesView type) { return type[0] == kString8Small || type[0] == kString8Large; }

class Comparison {
 public:
  Comparison(const Structures& writer, const Structures& reader)
      : writer_(writer), reader_(reader) {}

  bool assignable(const EquivalenceHash& writer, const EquivalenceHash& reader, int depth = 0) {
    if (writer == reader) return true;
    const auto from = writer_.find(writer);
    const auto to = reader_.find(reader);
    return depth < kDeepest && from != writer_.end() && to != reader_.end() &&
           assignable(from->second, to->second, depth);
  }

 private:
  // XTypes 7.2.4.4.8, with the defaults of TYPE_CONSISTENCY_ENFORCEMENT: bounds of strings do not
  // count; what one side has more, at the end of an appendable type, is no key.
  bool assignable(const Structure& from, const Structure& to, int depth) {
    if ((from.flags & kExtensibility) != (to.flags & kExtensibility)) return false;
    const auto common = std::min(from.members.size(), to.members.size());
    const bool as_long = from.members.size() == to.members.size();
    if ((from.flags & kFinal) != 0 && !as_long) return false;
    for (std::size_t i = 0; i < common; ++i)
      if (!assignable(from.members[i], to.members[i], depth)) return false;
    const auto& longer = from.members.size() > common ? from.members : to.members;
    return common > 0 &&
           std::none_of(longer.begin() + static_cast<std::ptrdiff_t>(common), longer.end(),
                        [](const Member& m) { return (m.flags & kKey) != 0; });
  }

  bool assignable(const Member& from, const Member& to, int depth) {
    constexpr std::uint16_t kCounts = kOptional | kKey;
    if (from.id != to.id || (from.flags & kCounts) != (to.flags & kCounts) ||
        !std::ranges::equal(from.name_hash, to.name_hash))
      return false;
    if (std::ranges::equal(from.type, to.type) || (is_string(from.type) && is_string(to.type)))
      return true;
    const auto writer = hash_in(from.type), reader = hash_in(to.type);
    return writer && reader && assignable(*writer, *reader, depth + 1);
  }

  const Structures& writer_;
  const Structures& reader_;
};

}  // namespace

std::optional<EquivalenceHash> minimal_hash(BytesView type_information) {
  const auto hash = read_minimal_hash(type_information);
  return hash ? std::optional(*hash) : std::nullopt;
}

TypeVerdict judge_types(const TypeDescription& writer, const TypeDescription& reader) {
  const auto from = minimal_hash(writer.information), to = minimal_hash(reader.information);
  if (!from || !to) return TypeVerdict::unknown;
  if (*from == *to) return TypeVerdict::same;
  const auto writers = read_objects(writer.objects), readers = read_objects(reader.objects);
  if (!writers || !readers || !writers->contains(*from) || !readers->contains(*to))
    return TypeVerdict::unknown;
  return Comparison(*writers, *readers).assignable(*from, *to) ? TypeVerdict::assignable
                                                               : TypeVerdict::different;
}

std::string describe_type(const std::string& name, const TypeDescription& type) {
  const auto hash = minimal_hash(type.information);
  return hash ? name + " (minimal type " + to_hex(*hash) + ")" : name;
}

}  // namespace ddssec::rtps
