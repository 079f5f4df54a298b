// Parameter lists: inline QoS and PL_CDR (RTPS 9.4.2.11, 9.6.3).
#pragma once

#include <optional>
#include <string_view>

#include "base/reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

/// ParameterId_t. A number, not an enumeration: most ids of other vendors are skipped.
using ParameterId = std::uint16_t;

namespace pid {
inline constexpr ParameterId kPad = 0x0000;
inline constexpr ParameterId kSentinel = 0x0001;
inline constexpr ParameterId kContentFilterProperty = 0x0035;
inline constexpr ParameterId kContentFilterInfo = 0x0055;
inline constexpr ParameterId kCoherentSet = 0x0056;
inline constexpr ParameterId kOriginalWriterInfo = 0x0061;
inline constexpr ParameterId kGroupCoherentSet = 0x0063;
inline constexpr ParameterId kGroupSeqNum = 0x0064;
inline constexpr ParameterId kWriterGroupInfo = 0x0065;
inline constexpr ParameterId kKeyHash = 0x0070;
inline constexpr ParameterId kStatusInfo = 0x0071;
/// A reader that does not know an id with this bit must not use the sample (RTPS 9.6.3.1).
inline constexpr ParameterId kMustUnderstand = 0x4000;
inline constexpr ParameterId kVendorSpecific = 0x8000;
/// Specific to ddssec: the source timestamp of a DATA, as Time_t.
inline constexpr ParameterId kSourceTime = 0x8d5e;
}  // namespace pid

struct Parameter {
  ParameterId id = 0;
  BytesView value;  ///< a multiple of 4 octets; CDR alignment counts from its first octet
  Endian endian = Endian::little;
  Reader reader() const { return Reader(value, endian); }
};

/// Iterates over a list in place. PAD is skipped. The list must end with its sentinel.
class ParameterReader {
 public:
  ParameterReader(BytesView list, Endian endian) : reader_(list, endian) {}

  /// Returns the next parameter, or empty at the sentinel. Errors: truncated (no sentinel),
  /// rtps_parameter_invalid (the length is not a multiple of 4).
  Result<std::optional<Parameter>> next();
  /// The number of octets read so far; after the sentinel, the size of the list.
  std::size_t consumed() const { return reader_.position(); }

 private:
  Reader reader_;
  bool done_ = false;
};

/// Returns the list at the beginning of `octets`, including its sentinel; the length of every
/// parameter has been checked. Errors: as for ParameterReader::next.
Result<BytesView> parameter_list_prefix(BytesView octets, Endian endian);

/// Writes a parameter header in its constructor. Its destructor pads and sets the length.
class ParameterScope {
 public:
  ParameterScope(SpanWriter& out, ParameterId id) : out_(out) {
    out_.write(id);
    out_.write(std::uint16_t{0});
    begin_ = out_.size();
  }
  ~ParameterScope() {
    out_.align(4);
    if (!out_.overflowed())
      out_.patch(begin_ - 2, static_cast<std::uint16_t>(out_.size() - begin_));
  }
  ParameterScope(const ParameterScope&) = delete;
  ParameterScope& operator=(const ParameterScope&) = delete;

 private:
  SpanWriter& out_;
  std::size_t begin_ = 0;
};

inline void write_sentinel(SpanWriter& out) {
  out.write(pid::kSentinel);
  out.write(std::uint16_t{0});
}

}  // namespace ddssec::rtps
