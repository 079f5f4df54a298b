// The parts common to all submessages: id, flags and length (RTPS 9.4.5.1). They are read in place.
#pragma once

#include <cstdint>

#include "base/ids.hpp"
#include "base/reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

enum class SubmessageId : std::uint8_t {
  header_extension = 0x00,
  pad = 0x01,
  acknack = 0x06,
  heartbeat = 0x07,
  gap = 0x08,
  info_timestamp = 0x09,
  info_source = 0x0c,
  info_reply_ip4 = 0x0d,
  info_destination = 0x0e,
  info_reply = 0x0f,
  nack_frag = 0x12,
  heartbeat_frag = 0x13,
  data = 0x15,
  data_frag = 0x16,
  secure_body = 0x30,
  secure_prefix = 0x31,
  secure_postfix = 0x32,
  secure_rtps_prefix = 0x33,
  secure_rtps_postfix = 0x34,
};

inline constexpr std::uint8_t kFlagLittleEndian = 0x01;
inline constexpr std::size_t kSubmessageHeaderSize = 4;

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

/// Each reads one value in place. Error: truncated.
Result<EntityId> read_entity_id(Reader& reader);
Result<GuidPrefix> read_guid_prefix(Reader& reader);
Result<Guid> read_guid(Reader& reader);

}  // namespace ddssec::rtps
