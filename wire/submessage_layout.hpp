// Where the submessages that a writer and a reader exchange have the ids of both (RTPS 9.4.5), for
// code that must find them before it may trust the rest.
#pragma once

#include <cstddef>
#include <optional>

#include "base/submessage_ids.hpp"

namespace ddssec::rtps {

/// Positions count from the first octet of the submessage header.
struct SubmessageLayout {
  std::size_t reader_at;
  std::size_t writer_at;
  std::size_t min_size;  ///< the fixed part of the submessage, with an empty number set
  bool is_of_reader;     ///< its sender is the reader

  constexpr std::size_t sender_at() const { return is_of_reader ? reader_at : writer_at; }
};

/// Returns the layout; empty for a submessage that names no reader and writer.
constexpr std::optional<SubmessageLayout> layout_of(SubmessageId id) {
  switch (id) {
    case SubmessageId::data:
      return SubmessageLayout{8, 12, 24, false};
    case SubmessageId::data_frag:
      return SubmessageLayout{8, 12, 36, false};
    case SubmessageId::gap:
    case SubmessageId::heartbeat:
      return SubmessageLayout{4, 8, 32, false};
    case SubmessageId::heartbeat_frag:
      return SubmessageLayout{4, 8, 28, false};
    case SubmessageId::acknack:
      return SubmessageLayout{4, 8, 28, true};
    case SubmessageId::nack_frag:
      return SubmessageLayout{4, 8, 32, true};
    default:
      return std::nullopt;
  }
}

}  // namespace ddssec::rtps
