// One table for each builtin type: each parameter's id, and how it is read and written.
#pragma once

#include <algorithm>
#include <span>
#include <string>

#include "rtps/cdr/encapsulation.hpp"
#include "wire/locator.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

/// Limits for announced data; an announcement above a limit is refused before it is stored.
inline constexpr std::size_t kMaxLocators = 16;
inline constexpr std::size_t kMaxProperties = 64;
inline constexpr std::size_t kMaxOpaqueOctets = 4096;

/// One parameter of an announcement: how it is read into a T and written from one.
template <class T>
struct ParameterRow {
  ParameterId id;
  Status (*read)(Reader& reader, T& value);
  /// Writes the whole parameter, or nothing if the value is the default.
  void (*write)(SpanWriter& out, const T& value);
  bool repeatable = false;  ///< a list may give several values (SingleParameters)
  bool required = false;
};

/// Writes the encapsulation in front of a PL_CDR payload.
void write_pl_cdr_encapsulation(SpanWriter& out);
/// Returns the list after the encapsulation, which must be PL_CDR in either byte order. Errors:
/// those of open_payload, rtps_encapsulation_unsupported.
Result<SerializedPayload> open_pl_cdr(BytesView payload);

/// Reads a list by its table. Errors: those of ParameterReader, of SingleParameters and of the
/// rows, rtps_parameter_not_understood, rtps_parameter_missing.
template <class T>
Result<T> read_parameters(std::span<const ParameterRow<T>> table, BytesView list, Endian endian) {
  T value{};
  SingleParameters single;
  std::bitset<SingleParameters::kMax> seen;
  ParameterReader parameters(list, endian);
  for (;;) {
    const auto parameter = parameters.next();
    if (!parameter) return std::unexpected(parameter.error());
    if (!*parameter) break;
    const auto id = (*parameter)->id;
    const auto row = std::ranges::find(table, id, &ParameterRow<T>::id);
    if (row == table.end()) {
      const bool essential = (id & pid::kMustUnderstand) != 0 && (id & pid::kVendorSpecific) == 0;
      if (essential) return fail(Code::rtps_parameter_not_understood);
      continue;
    }
    const auto index = static_cast<std::size_t>(row - table.begin());
    seen.set(index);
    if (!row->repeatable)
      if (auto status = single.note(index); !status) return std::unexpected(status.error());
    auto reader = (*parameter)->reader();
    if (auto status = row->read(reader, value); !status) return std::unexpected(status.error());
  }
  for (std::size_t i = 0; i < table.size(); ++i)
    if (table[i].required && !seen[i]) return fail(Code::rtps_parameter_missing);
  return value;
}

/// Writes all rows and the sentinel, without encapsulation.
template <class T>
void write_parameters(std::span<const ParameterRow<T>> table, SpanWriter& out, const T& value) {
  for (const auto& row : table) row.write(out, value);
  write_sentinel(out);
}

// Functions for values that occur in more than one table.
/// Reads a string. Errors: those of Reader::read_string, length_out_of_range (more than
/// `max_length` octets).
Result<std::string> read_bounded_string(Reader& reader, std::size_t max_length);
/// Reads an octet sequence. Errors: truncated, length_out_of_range.
Result<Bytes> read_opaque(Reader& reader);
/// Reads a locator and appends it. Errors: those of read_locator, length_out_of_range (the list has
/// kMaxLocators).
Status read_locator_into(Reader& reader, LocatorList& list);
void write_text(SpanWriter& out, std::string_view text);
void write_opaque(SpanWriter& out, BytesView octets);
void write_locators(SpanWriter& out, ParameterId id, const LocatorList& list);

}  // namespace ddssec::rtps
