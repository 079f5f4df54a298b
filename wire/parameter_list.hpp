// Parameter lists: inline QoS and PL_CDR (RTPS 9.4.2.11, 9.6.3).
#pragma once

#include <optional>
#include <string_view>

#include "base/parameter_ids.hpp"
#include "base/reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

using ParameterId = pid::Id;

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
