// The tables of a store of samples, in this version and in earlier ones.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace ddssec::rtps {

constexpr std::int64_t kApplicationId = 0x44445353;  // "DDSS"
// Version 2 did not store the sender of a sample, version 3 did not store up to which change a
// writer was heard, and version 4 did not store when a sample expires.
constexpr std::int64_t kVersion = 5, kMinVersion = 2;

constexpr std::string_view kSchema[] = {
    "CREATE TABLE stream(id INTEGER PRIMARY KEY, domain INTEGER NOT NULL, topic TEXT NOT NULL, "
    "type TEXT NOT NULL, partition BLOB NOT NULL, ordinal INTEGER NOT NULL, "
    "UNIQUE(domain, topic, type, partition, ordinal))",
    "CREATE TABLE sample(id INTEGER PRIMARY KEY, stream INTEGER NOT NULL, key BLOB NOT NULL, "
    "keyed INTEGER NOT NULL, disposed INTEGER NOT NULL, seconds INTEGER NOT NULL, "
    "fraction INTEGER NOT NULL, writer BLOB NOT NULL, number INTEGER NOT NULL, "
    "payload BLOB NOT NULL, sum BLOB NOT NULL, identity BLOB, expires INTEGER, lifespan INTEGER)",
    "CREATE INDEX sample_of_stream ON sample(stream, id)",
    // A row with number 0 is about an instance that has ended: `writer` is a digest of its key.
    "CREATE TABLE heard(stream INTEGER NOT NULL, writer BLOB NOT NULL, number INTEGER NOT NULL, "
    "time INTEGER NOT NULL, used INTEGER NOT NULL, PRIMARY KEY(stream, writer)) WITHOUT ROWID"};

/// A column that stores of an earlier version lack.
struct AddedColumn {
  std::int64_t since;     ///< the first version that has it
  std::string_view text;  ///< the text in the table
};
/// The last columns of the table of samples, in their order.
constexpr AddedColumn kAddedColumns[] = {
    {3, "identity BLOB"}, {5, "expires INTEGER"}, {5, "lifespan INTEGER"}};

/// Returns the text as SQLite stores it, which is the text that was executed.
inline std::string schema_of(std::int64_t version, std::string_view sql) {
  std::string out(sql);
  for (const auto& [since, column] : kAddedColumns) {
    const auto text = ", " + std::string(column);
    if (const auto at = out.find(text); version < since && at != std::string::npos)
      out.erase(at, text.size());
  }
  return out;
}

}  // namespace ddssec::rtps
