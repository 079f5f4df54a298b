#include "rtps/durability/heard_writers.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace ddssec::rtps {
namespace {

constexpr std::size_t kOctetsPerEntry = 1024;

// The number of an entry about an ended instance. Writers number their changes from 1 on.
constexpr SequenceNumber kEnded{0};

// The number of entries of each stream, largest first.
using StreamSizes = std::vector<std::pair<std::size_t, StreamId>>;

Result<StreamSizes> sizes_of_streams(Database& database) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto rows,
      database.prepare("SELECT count(*), stream FROM heard GROUP BY stream ORDER BY 1 DESC"));
  StreamSizes out;
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
    if (!has_row) return out;
    out.push_back({static_cast<std::size_t>(rows.number(0)), StreamId{rows.number(1)}});
  }
}

// Returns the largest size that leaves at most `max_entries`, if larger streams shrink to it.
std::size_t size_for(const StreamSizes& sizes, std::size_t max_entries) {
  auto left = max_entries;
  for (auto at = sizes.rbegin(); at != sizes.rend(); ++at) {
    const auto share = left / static_cast<std::size_t>(sizes.rend() - at);
    if (at->first > share) return share;
    left -= at->first;
  }
  return sizes.empty() ? 0 : sizes.front().first;
}

Guid guid_from(BytesView octets) {
  return {GuidPrefix::from(octets.first(12)), EntityId::from(octets.subspan(12))};
}

}  // namespace

Status HeardWriters::open(Database& database, std::size_t max_octets) {
  DDSSEC_ASSIGN_OR_RETURN(renew_, database.prepare("UPDATE heard SET number = max(number, ?3), "
                                                   "time = max(time, ?4), used = ?5 "
                                                   "WHERE stream = ?1 AND writer = ?2"));
  DDSSEC_ASSIGN_OR_RETURN(insert_, database.prepare("INSERT INTO heard(stream, writer, number, "
                                                    "time, used) VALUES(?1, ?2, ?3, ?4, ?5)"));
  DDSSEC_ASSIGN_OR_RETURN(erase_,
                          database.prepare("DELETE FROM heard WHERE stream = ?1 AND writer = ?2"));
  max_ = std::min(kMax, max_octets / kOctetsPerEntry);
  DDSSEC_ASSIGN_OR_RETURN(const auto entries, database.number("SELECT count(*) FROM heard"));
  counters_.entries = static_cast<std::size_t>(entries);
  DDSSEC_ASSIGN_OR_RETURN(counters_.last_use,
                          database.number("SELECT coalesce(max(used), 0) FROM heard"));
  return {};
}

Status HeardWriters::remember(Database& database, std::span<const StoredChange* const> changes) {
  std::map<std::pair<StreamId, Guid>, HeardWriter> latest;
  for (const auto* stored : changes) {
    for (const auto& end : stored->ends)
      DDSSEC_RETURN_IF_ERROR(remember(database, stored->stream, end));
    if (!stored->is_remembered) continue;
    const auto origin = stored->change.origin();
    const auto time = stored->change.source_time.value_or(Time{});
    auto& heard = latest.try_emplace({stored->stream, origin.writer}, origin.writer).first->second;
    heard.number = std::max(heard.number, origin.number);
    heard.time = std::max(heard.time, time);
  }
  for (const auto& [key, heard] : latest)
    DDSSEC_RETURN_IF_ERROR(remember(database, key.first, heard));
  return counters_.entries > max_ ? forget_longest_unused(database) : Status{};
}

Status HeardWriters::remember(Database& database, StreamId stream, const HeardWriter& heard) {
  const auto writer = heard.writer.octets();
  ++counters_.last_use;
  const auto run = [&](SqlStatement& statement) {
    return statement.bind(1, stream.value)
        .bind(2, BytesView(writer))
        .bind(3, heard.number.value)
        .bind(4, heard.time.to_nanoseconds().count())
        .bind(5, counters_.last_use)
        .run();
  };
  DDSSEC_RETURN_IF_ERROR(run(renew_));
  if (database.changes() > 0) return {};
  DDSSEC_RETURN_IF_ERROR(run(insert_));
  ++counters_.entries;
  return {};
}

Status HeardWriters::remember(Database& database, StreamId stream, const StoredEnd& end) {
  if (!end.is_forgotten)
    return remember(database, stream, HeardWriter{guid_from(end.instance), kEnded, end.time});
  DDSSEC_RETURN_IF_ERROR(erase_.bind(1, stream.value).bind(2, BytesView(end.instance)).run());
  counters_.entries -= std::min(counters_.entries, static_cast<std::size_t>(database.changes()));
  return {};
}

// Several entries are forgotten at once, because the search looks at all of them.
Status HeardWriters::forget_longest_unused(Database& database) {
  DDSSEC_ASSIGN_OR_RETURN(const auto sizes, sizes_of_streams(database));
  const auto size = size_for(sizes, max_ - max_ / 16);
  for (const auto& [entries, stream] : sizes)
    if (entries > size)
      DDSSEC_RETURN_IF_ERROR(forget_longest_unused(database, stream, entries - size));
  DDSSEC_ASSIGN_OR_RETURN(const auto left, database.number("SELECT count(*) FROM heard"));
  counters_.entries = static_cast<std::size_t>(left);
  return {};
}

// No two entries were used at the same time.
Status HeardWriters::forget_longest_unused(Database& database, StreamId stream, std::size_t count) {
  const auto of_stream = " FROM heard WHERE stream = " + std::to_string(stream.value);
  return database.run("DELETE" + of_stream + " AND used <= (SELECT used" + of_stream +
                      " ORDER BY used LIMIT 1 OFFSET " + std::to_string(count - 1) + ")");
}

Status HeardWriters::forget(Database& database, StreamId stream) {
  DDSSEC_RETURN_IF_ERROR(
      database.run("DELETE FROM heard WHERE stream = " + std::to_string(stream.value)));
  counters_.entries -= std::min(counters_.entries, static_cast<std::size_t>(database.changes()));
  return {};
}

Result<bool> HeardWriters::load(Database& database, StreamId stream, StoredHistory& out) const {
  DDSSEC_ASSIGN_OR_RETURN(
      auto rows, database.prepare("SELECT writer, number, time FROM heard WHERE stream = ?"));
  rows.bind(1, stream.value);
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
    if (!has_row) return true;

    const auto octets = rows.octets(0);
    const SequenceNumber number{rows.number(1)};
    const auto time = Time::from(std::chrono::nanoseconds(rows.number(2)));
    if (octets.size() != Guid{}.octets().size()) return false;
    if (number != kEnded) {
      out.heard.push_back({guid_from(octets), number, time});
      continue;
    }
    auto& end = out.ends.emplace_back(StoredEnd{.time = time});
    std::ranges::copy(octets, end.instance.begin());
  }
}

}  // namespace ddssec::rtps
