// DATA_FRAG: consecutive fragments of one large change (RTPS 9.4.5.4).
#pragma once

#include "wire/data.hpp"

namespace ddssec::rtps {

/// Borrows its payload, which is exactly the octets of fragments first .. first + count - 1.
/// Fragment n covers the sample's octets from (n - 1) * fragment_size on; only the last fragment
/// may be shorter.
struct DataFrag {
  EntityId reader;
  EntityId writer;
  SequenceNumber sequence_number{1};
  FragmentNumber first{1};
  std::uint16_t count = 1;
  std::uint16_t fragment_size = 0;
  std::uint32_t sample_size = 0;
  InlineQos inline_qos = {};
  bool is_key = false;
  /// The octets of these fragments and no more; `write` does not check it.
  BytesView payload = {};
  /// In a received submessage, everything after the fixed part and the inline QoS. A protected
  /// fragment is longer than the octets that it covers (DDS-Security 1.2, clause 9.5.1.10.1).
  BytesView encoded = {};

  /// Returns the number of fragments of the whole sample.
  std::uint32_t total() const { return fragments_of(sample_size, fragment_size); }
  static constexpr std::uint32_t fragments_of(std::uint32_t sample_size, std::uint16_t size) {
    return size == 0 ? 0
                     : static_cast<std::uint32_t>((std::uint64_t{sample_size} + size - 1) / size);
  }
};

/// Errors: truncated (also if there are fewer octets than the fragments have), rtps_number_invalid
/// (fragment numbers or sizes that do not fit the sample; CVE-2023-50716, CVE-2025-62799,
/// CVE-2025-65865), rtps_submessage_overrun, those of read_inline_qos.
Result<DataFrag> read_data_frag(const SubmessageView& view);
/// Returns the same fragments with `plain`, their unprotected octets, as payload. Errors:
/// truncated, rtps_number_invalid.
Result<DataFrag> with_payload(DataFrag frag, BytesView plain);
void write(SpanWriter& out, const DataFrag& data);

}  // namespace ddssec::rtps
