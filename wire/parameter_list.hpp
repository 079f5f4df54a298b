// Parameter lists: inline QoS and PL_CDR (RTPS 9.4.2.11, 9.6.3).
#pragma once

#include <bitset>
#include <optional>

#include "base/parameter_ids.hpp"
#include "base/reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

using ParameterId = pid::Id;

/// One parameter of a received list. Borrows the list's octets.
struct Parameter {
  ParameterId id = 0;
  BytesView value;  ///< a multiple of 4 octets; CDR alignment counts from its first octet
  Endian endian = Endian::little;
  Reader reader() const { return Reader(value, endian); }
};

/// The octets in front of each value.
struct ParameterHeader {
  static constexpr std::size_t size = 4;

  ParameterId id = 0;
  std::uint16_t length = 0;  ///< of the value, a multiple of 4; any number at the sentinel

  bool is_sentinel() const { return id == pid::kSentinel; }
};
/// Reads a header. Every reader of parameter lists does it by this function. Errors: truncated,
/// rtps_parameter_invalid (the length is not a multiple of 4, and this is not the sentinel).
Result<ParameterHeader> read_parameter_header(Reader& reader);

/// Iterates over a list in place, and allocates nothing.
class ParameterReader {
 public:
  ParameterReader(BytesView list, Endian endian) : reader_(list, endian) {}

  /// Returns the next parameter, or empty at the sentinel. PAD is skipped. Errors: truncated (the
  /// list ends before its sentinel), rtps_parameter_invalid (the length is not a multiple of 4).
  Result<std::optional<Parameter>> next();
  /// As next, but returns PAD as well.
  Result<std::optional<Parameter>> next_or_pad();
  /// True after the sentinel, or if no octets are left. A caller that accepts a list without a
  /// sentinel asks this before next_or_pad.
  bool at_end() const { return is_done_ || reader_.at_end(); }
  /// Returns the number of octets read so far; after the sentinel, the size of the list.
  std::size_t consumed() const { return reader_.position(); }

 private:
  Reader reader_;
  bool is_done_ = false;
};

/// Finds parameters that are repeated although they have one value. A list may repeat an id to give
/// several values of one kind, such as locators (RTPS 2.5, 9.4.2.11). All other parameters have one
/// value: if a list has two, it is refused, because two readers could take different values from
/// it. Cyclone DDS has the same rule.
class SingleParameters {
 public:
  static constexpr std::size_t kMax = 64;

  /// Notes that a list has a parameter with one value. `index` is the position of its id in a table
  /// of at most kMax. Error: rtps_parameter_invalid (the list already had the parameter).
  Status note(std::size_t index) {
    if (has(index)) return fail(Code::rtps_parameter_invalid);
    noted_.set(index);
    return {};
  }
  bool has(std::size_t index) const { return noted_[index]; }

 private:
  std::bitset<kMax> noted_;
};

/// Returns the list at the beginning of `octets`, including its sentinel. The length of every
/// parameter has been checked. Errors: those of ParameterReader::next.
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
