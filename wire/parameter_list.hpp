// Parameter lists: inline QoS and PL_CDR (RTPS 9.4.2.11, 9.6.3).
#pragma once

#include <optional>
#include <string_view>

#include "base/reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

/// ParameterId_t. Kept as a number: most ids of other vendors are stepped over.
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
/// A reader that does not know such an id must not use the sample (RTPS 9.6.3.1).
inline constexpr ParameterId kMustUnderstand = 0x4000;
inline constexpr ParameterId kVendorSpecific = 0x8000;
/// Ours: the source timestamp of a DATA, as Time_t.
inline constexpr ParameterId kSourceTime = 0x8d5e;
}  // namespace pid

struct Parameter {
  ParameterId id = 0;
  BytesView value;  ///< a multiple of 4 octets; CDR alignment counts from its first octet
  Endian endian = Endian::little;
  Reader reader() const { return Reader(value, endian); }
};

/// Walks a list in place. PAD is stepped over; the list ends with its sentinel, which must be
/// there.
class ParameterReader {
 public:
  ParameterReader(BytesView list, Endian endian) : reader_(list, endian) {}

  /// The next parameter, or nothing behind the sentinel. Errors: truncated (no sentinel),
  /// rtps_parameter_invalid (length no multiple of 4).
  Result<std::optional<Parameter>> next();
  /// How many octets have been walked over; behind the sentinel: the size of the list.
  std::size_t consumed() const { return reader_.position(); }

 private:
  Reader reader_;
  bool done_ = false;
};

/// The list at the beginning of `octets`, its sentinel included; every parameter's length has been
/// checked. Errors as ParameterReader::next.
Result<BytesView> parameter_list_prefix(BytesView octets, Endian endian);

/// Begins a parameter on construction, pads and sets its length when it goes out of scope.
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
