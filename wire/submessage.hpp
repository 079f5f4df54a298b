// The parts common to all submessages: id, flags and length (RTPS 9.4.5.1). They are read in place.
#pragma once

#include <cstdint>

#include "base/ids.hpp"
#include "base/reader.hpp"
#include "base/submessage_ids.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

using ddssec::kSubmessageHeaderSize;
using ddssec::SubmessageId;

/// One submessage in a received message. Borrows the message's octets.
struct SubmessageView {
  SubmessageId id{};
  std::uint8_t flags = 0;
  BytesView body;   ///< after the submessage header
  BytesView whole;  ///< includes the header; this is what a transform protects

  Endian endian() const { return flags & kFlagLittleEndian ? Endian::little : Endian::big; }
  bool has(std::uint8_t flag) const { return (flags & flag) != 0; }
  Reader reader() const { return Reader(body, endian()); }
};

/// Writes a submessage header in its constructor. Its destructor pads to a multiple of 4 octets and
/// sets the length.
class SubmessageScope {
 public:
  SubmessageScope(SpanWriter& out, SubmessageId id, std::uint8_t flags = 0) : out_(out) {
    const auto endian = out.endian() == Endian::little ? kFlagLittleEndian : std::uint8_t{0};
    out_.write(static_cast<std::uint8_t>(id));
    out_.write(static_cast<std::uint8_t>(flags | endian));
    out_.write(std::uint16_t{0});
    begin_ = out_.size();
  }
  ~SubmessageScope() {
    out_.align(4);
    if (!out_.overflowed())
      out_.patch(begin_ - 2, static_cast<std::uint16_t>(out_.size() - begin_));
  }
  SubmessageScope(const SubmessageScope&) = delete;
  SubmessageScope& operator=(const SubmessageScope&) = delete;

 private:
  SpanWriter& out_;
  std::size_t begin_ = 0;
};

/// Reads one value in place. Error: truncated.
Result<EntityId> read_entity_id(Reader& reader);
/// Reads one value in place. Error: truncated.
Result<GuidPrefix> read_guid_prefix(Reader& reader);
/// Reads one value in place. Error: truncated.
Result<Guid> read_guid(Reader& reader);

}  // namespace ddssec::rtps
