// One row of the table of samples.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "rtps/durability/database.hpp"
#include "rtps/durability/stored_change.hpp"

namespace ddssec::rtps {

/// A sample in the store.
struct SampleRow {
  Change change = {};
  std::optional<GuidPrefix> identity = {};
  std::optional<StoredExpiry> expiry = {};
};

constexpr std::string_view kSelectSamples =
    "SELECT id, key, keyed, disposed, seconds, fraction, payload, sum, writer, number, identity, "
    "expires, lifespan, stream FROM sample ";

/// Reads a row of kSelectSamples, whose first column is the row's number. Returns empty if it
/// differs from what was stored.
std::optional<SampleRow> read_row(const SqlStatement& row);

/// Returns empty if no limit applies, or if an earlier version stored the sample.
std::optional<GuidPrefix> identity_from(BytesView octets);

/// A checksum of the contents, because SQLite detects damage only to its own structures.
using SampleSum = std::array<std::uint8_t, 8>;
SampleSum sum_of(std::int64_t row, StreamId stream, const Change& change,
                 const std::optional<StoredExpiry>& expiry);

}  // namespace ddssec::rtps
