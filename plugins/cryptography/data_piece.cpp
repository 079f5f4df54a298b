#include "plugins/cryptography/data_piece.hpp"

#include <algorithm>

#include "plugins/cryptography/crypto_framing.hpp"
#include "wire/parameter_list.hpp"
#include "wire/submessage_layout.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::uint8_t kInlineQosFlag = 0x02;
constexpr std::uint8_t kDataFlag = 0x04;     // a flag of DATA
constexpr std::uint8_t kKeyFlag = 0x08;      // a flag of DATA
constexpr std::uint8_t kFragKeyFlag = 0x04;  // a flag of DATA_FRAG
// The same for DATA and DATA_FRAG.
constexpr auto kDataLayout = *rtps::layout_of(SubmessageId::data);
// The same for GAP, HEARTBEAT, ACKNACK and NACK_FRAG.
constexpr auto kLayout = *rtps::layout_of(SubmessageId::gap);
constexpr std::size_t kEntitiesEnd = kLayout.writer_at + EntityId::size;

// Reads the fields of a DATA_FRAG after writerSN; returns the number of octets of the sample that
// it contains.
Result<std::uint64_t> read_fragment(Reader& in, DataPiece& piece) {
  DDSSEC_ASSIGN_OR_RETURN(const auto first, in.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto count, in.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(piece.fragment_size, in.read<std::uint16_t>());
  DDSSEC_ASSIGN_OR_RETURN(const std::uint64_t whole, in.read<std::uint32_t>());
  if (first == 0 || count == 0 || piece.fragment_size == 0) return fail(Code::malformed);
  const auto begin = std::uint64_t{first - 1} * piece.fragment_size;
  if (begin >= whole) return fail(Code::malformed);
  piece.begins_sample = first == 1;
  piece.first_fragment = first;
  piece.sample_size = static_cast<std::uint32_t>(whole);
  const auto size = std::min(std::uint64_t{count} * piece.fragment_size, whole - begin);
  piece.fragments_size = static_cast<std::uint32_t>(size);
  return size;
}

Result<std::uint64_t> read_number(Reader& in) {
  DDSSEC_ASSIGN_OR_RETURN(const std::uint64_t high, in.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto number, in.read<std::uint32_t>());
  return high << 32 | number;
}

Endian endian_of(BytesView submessage) {
  return (submessage[1] & kFlagLittleEndian) != 0 ? Endian::little : Endian::big;
}

// Reads a GAP from after the ids of reader and writer.
Result<SkippedRanges> read_gap(Reader& in, const EntityId& writer) {
  constexpr std::uint32_t kMaxBits = 256;
  DDSSEC_ASSIGN_OR_RETURN(const auto begin, read_number(in));
  DDSSEC_ASSIGN_OR_RETURN(const auto base, read_number(in));
  SkippedRanges out{writer, {{begin, base}}};
  DDSSEC_ASSIGN_OR_RETURN(const auto number, in.read<std::uint32_t>());
  const auto bits = std::min(number, kMaxBits);
  for (std::uint32_t word = 0; word < (bits + 31) / 32; ++word) {
    DDSSEC_ASSIGN_OR_RETURN(const auto set, in.read<std::uint32_t>());
    for (std::uint32_t bit = 0; bit < 32; ++bit)
      if ((set >> (31 - bit) & 1) != 0)
        out.ranges.emplace_back(base + 32 * word + bit, base + 32 * word + bit + 1);
  }
  return out;
}

Result<SkippedRanges> read_heartbeat(Reader& in, const EntityId& writer) {
  DDSSEC_ASSIGN_OR_RETURN(const auto first, read_number(in));
  return SkippedRanges{writer, {{0, first}}};
}

}  // namespace

std::optional<EntityId> writer_of_data(BytesView submessage) {
  const auto id = submessage[0];
  if (id != submessage_id::kData && id != submessage_id::kDataFrag) return std::nullopt;
  if (submessage.size() < kDataLayout.writer_at + EntityId::size) return std::nullopt;
  return EntityId::from(submessage.subspan(kDataLayout.writer_at, EntityId::size));
}

EntityId reader_of_data(BytesView submessage) {
  return EntityId::from(submessage.subspan(kDataLayout.reader_at, EntityId::size));
}

std::optional<SkippedRanges> read_skipped(BytesView submessage) {
  const auto id = submessage[0];
  if (id != submessage_id::kGap && id != submessage_id::kHeartbeat) return std::nullopt;
  if (submessage.size() < kEntitiesEnd) return std::nullopt;
  const auto writer = EntityId::from(submessage.subspan(kLayout.writer_at));
  Reader in(submessage.subspan(kEntitiesEnd), endian_of(submessage));
  auto skipped = id == submessage_id::kGap ? read_gap(in, writer) : read_heartbeat(in, writer);
  return skipped ? std::optional(std::move(*skipped)) : std::nullopt;
}

std::optional<Acknowledgment> read_acknowledgment(BytesView submessage) {
  if (submessage.size() < kEntitiesEnd || submessage[0] != submessage_id::kAckNack)
    return std::nullopt;
  Reader in(submessage.subspan(kEntitiesEnd), endian_of(submessage));
  const auto next = read_number(in);
  if (!next) return std::nullopt;
  return Acknowledgment{EntityId::from(submessage.subspan(kLayout.writer_at)), *next};
}

std::optional<std::uint64_t> read_fragment_request(BytesView submessage) {
  if (submessage.size() < kEntitiesEnd || submessage[0] != submessage_id::kNackFrag)
    return std::nullopt;
  Reader in(submessage.subspan(kEntitiesEnd), endian_of(submessage));
  const auto number = read_number(in);
  return number ? std::optional(*number) : std::nullopt;
}

bool is_plain_cdr(BytesView payload) {
  constexpr std::size_t kEncapsulationSize = 4;
  return payload.size() >= kEncapsulationSize && payload[0] == 0 &&
         (payload[1] <= 1 || payload[1] == 6 || payload[1] == 7);
}

Result<DataPiece> read_data_piece(BytesView submessage) {
  const auto header = read_submessage_header(submessage);
  const bool is_fragment = header.id == submessage_id::kDataFrag;
  const bool key = (header.flags & (is_fragment ? kFragKeyFlag : kKeyFlag)) != 0;
  DataPiece piece{
      .writer = EntityId::from(submessage.subspan(kDataLayout.writer_at, EntityId::size)),
      .number = 0,
      .has_data = is_fragment ? !key : (header.flags & kDataFlag) != 0,
      .has_key = key,
      .is_fragment = is_fragment,
      .endian = endian_of(submessage),
      .inline_qos = {},
      .payload = {}};
  Reader in(submessage, piece.endian);
  DDSSEC_RETURN_IF_ERROR(in.skip(kSubmessageHeaderSize + 2));
  DDSSEC_ASSIGN_OR_RETURN(const auto to_inline_qos, in.read<std::uint16_t>());
  const auto counted_from = in.position();
  DDSSEC_RETURN_IF_ERROR(in.skip(2 * EntityId::size));
  DDSSEC_ASSIGN_OR_RETURN(piece.number, read_number(in));
  auto most = static_cast<std::uint64_t>(submessage.size());
  if (is_fragment) {
    DDSSEC_ASSIGN_OR_RETURN(most, read_fragment(in, piece));
  }
  if (to_inline_qos % 4 != 0 || counted_from + to_inline_qos < in.position())
    return fail(Code::malformed);
  DDSSEC_RETURN_IF_ERROR(in.skip(counted_from + to_inline_qos - in.position()));
  if ((header.flags & kInlineQosFlag) != 0) {
    DDSSEC_ASSIGN_OR_RETURN(piece.inline_qos, rtps::parameter_list_prefix(in.rest(), piece.endian));
    DDSSEC_RETURN_IF_ERROR(in.skip(piece.inline_qos.size()));
  }
  if (!piece.has_data && !piece.has_key) return piece;
  piece.payload = in.rest();
  if (piece.payload.size() > most)
    piece.payload = piece.payload.first(static_cast<std::size_t>(most));
  return piece;
}

}  // namespace ddssec::cryptography
