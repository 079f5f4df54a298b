// Parsing of DATA and DATA_FRAG for the checks of builtin messages. It reads no further than
// Cyclone DDS does.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "base/reader.hpp"

namespace ddssec::cryptography {

/// The part of a sample in one submessage. Views borrow from the submessage.
struct DataPiece {
  EntityId writer;
  std::uint64_t number;  ///< writerSN
  bool has_data;         ///< the payload is declared to be data
  /// The payload is declared to be a key; a hostile sender can declare both or neither.
  bool has_key;
  bool is_fragment;           ///< it is a DATA_FRAG
  bool begins_sample = true;  ///< false for a later fragment
  std::uint16_t fragment_size = 0;
  std::uint32_t first_fragment = 1;  ///< counted from 1
  std::uint32_t sample_size = 0;     ///< in a DATA_FRAG: octets of the whole sample
  std::uint32_t fragments_size = 0;  ///< in a DATA_FRAG: the least number of octets of its payload
  Endian endian;
  BytesView inline_qos;  ///< the parameter list; empty if there is none
  BytesView payload;     ///< the payload of this piece, from the encapsulation on
};

/// Returns the writer of a DATA or DATA_FRAG; empty for other submessages, and for one that ends
/// too early.
std::optional<EntityId> writer_of_data(BytesView submessage);

/// Returns the reader that a DATA or DATA_FRAG names; zero for all readers.
EntityId reader_of_data(BytesView submessage);

/// Parses a submessage for which writer_of_data is not empty. Errors: truncated, malformed,
/// rtps_parameter_invalid.
Result<DataPiece> read_data_piece(BytesView submessage);

/// The numbers that a GAP names, or those below the first number of a HEARTBEAT.
struct SkippedRanges {
  EntityId writer;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;  ///< begin and end
};
/// Reads such numbers; empty if the submessage is neither a GAP nor a HEARTBEAT, or ends too early.
std::optional<SkippedRanges> read_skipped(BytesView submessage);

/// The content of an ACKNACK from a local reader.
struct Acknowledgment {
  EntityId writer;
  std::uint64_t next;  ///< bitmapBase: the reader has all messages below
};
/// Reads an ACKNACK; empty for any other submessage.
std::optional<Acknowledgment> read_acknowledgment(BytesView submessage);

/// Returns the writerSN of a NACK_FRAG; empty for any other submessage, and for one that ends too
/// early.
std::optional<std::uint64_t> read_fragment_request(BytesView submessage);

/// True for a payload that begins with the encapsulation of plain CDR 1 or 2 in either byte order.
bool is_plain_cdr(BytesView payload);

}  // namespace ddssec::cryptography
