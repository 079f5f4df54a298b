// The ids of submessages, and the sizes and flags with which an RTPS message is taken apart.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ddssec {

/// The octet with which a submessage begins (RTPS 2.5, clause 9.4.5.1.1; DDS-Security 1.2, clause
/// 7.4.6.2).
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

/// The size of the RTPS header, and of the header of a submessage, in octets.
inline constexpr std::size_t kRtpsHeaderSize = 20;
inline constexpr std::size_t kSubmessageHeaderSize = 4;

/// Flag E of a submessage: little endian.
inline constexpr std::uint8_t kFlagLittleEndian = 0x01;
/// Flag P of SRTPS_PREFIX: protected by a pre-shared key (DDS-Security 1.2, clause 7.4.7.8).
inline constexpr std::uint8_t kFlagPreSharedKey = 0x04;

}  // namespace ddssec
