// A DATA or DATA_FRAG as the checks of builtin messages read it: no further than Cyclone DDS does.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "base/reader.hpp"

namespace ddssec::cryptography {

/// What one submessage says of a sample. Views borrow from the submessage.
struct DataPiece {
  EntityId writer;
  std::uint64_t number;       ///< writerSN
  bool has_data;              ///< a payload that is said to be data
  bool has_key;               ///< or a key; a hostile sender can say both, or nothing
  bool is_fragment;           ///< of DATA_FRAG
  bool begins_sample = true;  ///< false: a later fragment
  std::uint16_t fragment_size = 0;
  std::uint32_t first_fragment = 1;  ///< counted from 1
  std::uint32_t sample_size = 0;     ///< of DATA_FRAG: of the whole sample
  std::uint32_t fragments_size = 0;  ///< of DATA_FRAG: what its payload must have at least
  Endian endian;
  BytesView inline_qos;  ///< parameters up to the sentinel, which is left out
  BytesView payload;     ///< of this piece, from the encapsulation on
};

/// The writer of a DATA or DATA_FRAG; nothing if it is none, or ends too early to name one.
std::optional<EntityId> writer_of_data(BytesView submessage);

/// The reader of a submessage that has a writer; zero: all.
EntityId reader_of_data(BytesView submessage);

/// Of a submessage that has a writer. Errors: truncated, malformed.
Result<DataPiece> read_data_piece(BytesView submessage);

/// Numbers that a GAP names, or that lie below the first one of a HEARTBEAT.
struct Skipped {
  EntityId writer;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;  ///< begin and end
};
/// Nothing: it is neither, or ends too early.
std::optional<Skipped> read_skipped(BytesView submessage);

/// Of an ACKNACK of a local reader.
struct Acknowledgment {
  EntityId writer;
  std::uint64_t next;  ///< bitmapBase: the reader has all messages below
};
/// Nothing: it is none.
std::optional<Acknowledgment> read_acknowledgment(BytesView submessage);

/// One parameter of a parameter list (RTPS 9.4.2.11).
struct Parameter {
  std::uint16_t id;
  BytesView value;
};
/// The next one; nothing at the sentinel. Errors: truncated, malformed.
Result<std::optional<Parameter>> next_parameter(Reader& in);

}  // namespace ddssec::cryptography
