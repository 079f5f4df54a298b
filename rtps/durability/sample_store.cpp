#include "rtps/durability/sample_store.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/rollback.hpp"
#include "rtps/durability/sample_row.hpp"
#include "rtps/durability/store_disk.hpp"
#include "rtps/durability/store_file.hpp"
#include "rtps/durability/store_schema.hpp"

namespace ddssec::rtps {
namespace {

constexpr std::size_t kPageSize = 4096;
constexpr std::string_view kWithoutSamples =
    "NOT EXISTS (SELECT 1 FROM sample WHERE sample.stream = stream.id)";

// The octets include the length of each name, so that different lists never give the same octets.
Bytes partition_octets(const std::vector<std::string>& names) {
  Bytes out;
  for (const auto& name : names) {
    out.push_back(static_cast<std::uint8_t>(name.size() >> 8));
    out.push_back(static_cast<std::uint8_t>(name.size()));
    out.insert(out.end(), name.begin(), name.end());
  }
  return out;
}

// Does the same for partitions and scope. Without a scope, the octets are those that earlier
// versions stored.
Bytes partition_octets(const StreamKey& key) {
  constexpr std::array<std::uint8_t, 2> kLengthOfNoName{0xff, 0xff};
  auto out = partition_octets(key.partition);
  if (key.scope.empty()) return out;
  std::ranges::copy(kLengthOfNoName, std::back_inserter(out));
  std::ranges::copy(partition_octets(key.scope), std::back_inserter(out));
  return out;
}

SqlStatement& bind_key(SqlStatement& statement, const StreamKey& key, BytesView partition) {
  return statement.bind(1, std::int64_t{key.domain})
      .bind(2, std::string_view(key.topic))
      .bind(3, std::string_view(key.type))
      .bind(4, partition)
      .bind(5, std::int64_t{key.ordinal});
}

std::unexpected<Error> unusable_store_error(const std::string& path, std::string expected,
                                            std::string found) {
  return fail(Code::rtps_store_unusable,
              {.document = path, .expected = std::move(expected), .found = std::move(found)});
}

}  // namespace

Result<SampleStore> SampleStore::open(const std::string& path, std::size_t max_octets, Time now) {
  std::string guarded;
  if (!path.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(guarded, make_store_file(path));
  }
  DDSSEC_ASSIGN_OR_RETURN(auto database, Database::open(guarded));
  SampleStore store(std::move(database), path);
  DDSSEC_RETURN_IF_ERROR(store.prepare(max_octets, now));
  return store;
}

// First only reads, so that a file of another kind is not changed before it is refused.
Status SampleStore::prepare(std::size_t max_octets, Time now) {
  // EXCLUSIVE must be set before anything is read. Then the write-ahead log of a process that was
  // killed is recovered in memory, without another file next to it, even on a full disk. Removed
  // octets are not overwritten, because that would take as much room in the log.
  for (const auto* pragma : {"PRAGMA trusted_schema=OFF", "PRAGMA cell_size_check=ON",
                             "PRAGMA secure_delete=FAST", "PRAGMA locking_mode=EXCLUSIVE"})
    DDSSEC_RETURN_IF_ERROR(database_.run(pragma));
  DDSSEC_RETURN_IF_ERROR(check_origin());
  max_pages_ = std::max<std::size_t>(max_octets / kPageSize, 16);
  for (const auto& pragma :
       {std::string("PRAGMA journal_mode=WAL"), std::string("PRAGMA synchronous=FULL"),
        std::string("PRAGMA journal_size_limit=16777216"),
        "PRAGMA max_page_count=" + std::to_string(max_pages_)})
    DDSSEC_RETURN_IF_ERROR(database_.run(pragma));
  {
    DDSSEC_ASSIGN_OR_RETURN(auto transaction, Database::Transaction::begin(database_));
    DDSSEC_ASSIGN_OR_RETURN(const auto count,
                            database_.number("SELECT count(*) FROM sqlite_master"));
    if (count == 0)
      DDSSEC_RETURN_IF_ERROR(create_schema());
    else {
      DDSSEC_ASSIGN_OR_RETURN(const auto user_version, database_.number("PRAGMA user_version"));
      DDSSEC_RETURN_IF_ERROR(upgrade_schema(user_version));
    }
    DDSSEC_RETURN_IF_ERROR(transaction.commit());
  }
  DDSSEC_ASSIGN_OR_RETURN(
      insert_,
      database_.prepare("INSERT INTO sample(stream, key, keyed, disposed, seconds, "
                        "fraction, payload, sum, id, writer, number, identity, expires, lifespan) "
                        "VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  DDSSEC_ASSIGN_OR_RETURN(erase_, database_.prepare("DELETE FROM sample WHERE id = ?"));
  DDSSEC_ASSIGN_OR_RETURN(last_row_, database_.number("SELECT coalesce(max(id), 0) FROM sample"));
  [[maybe_unused]] const auto shortened = shorten_log();
  // If there is no room, expired samples and empty streams stay until there is some.
  for (const auto& erased : {erase_expired(now), erase_unused_streams()})
    if (!erased && erased.error().code() != Code::rtps_store_failed) return erased;
  DDSSEC_ASSIGN_OR_RETURN(last_stream_,
                          database_.number("SELECT max(coalesce((SELECT max(id) FROM stream), 0), "
                                           "coalesce((SELECT max(stream) FROM sample), 0))"));
  return heard_.open(database_, max_octets);
}

Status SampleStore::check_origin() {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, database_.number("SELECT count(*) FROM sqlite_master"));
  if (count == 0) {
    DDSSEC_ASSIGN_OR_RETURN(const auto application_id, database_.number("PRAGMA application_id"));
    if (application_id == 0) return {};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto id, database_.number("PRAGMA application_id"));
  if (id != kApplicationId)
    return unusable_store_error(path_, "a store of samples", "a database of another application");
  DDSSEC_ASSIGN_OR_RETURN(const auto version, database_.number("PRAGMA user_version"));
  if (version < kMinVersion || version > kVersion)
    return unusable_store_error(path_, "version " + std::to_string(kVersion),
                                "version " + std::to_string(version));
  DDSSEC_RETURN_IF_ERROR(check_schema(version));
  DDSSEC_ASSIGN_OR_RETURN(auto check, database_.prepare("PRAGMA integrity_check(1)"));
  DDSSEC_RETURN_IF_ERROR(check.step());
  if (check.text(0) != "ok")
    return unusable_store_error(path_, "a store that is whole", check.text(0));
  return {};
}

// The schema must be exactly the expected one, so that no trigger or view in a file is ever
// executed.
Status SampleStore::check_schema(std::int64_t version) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto statement,
      database_.prepare("SELECT sql FROM sqlite_master WHERE sql IS NOT NULL ORDER BY rowid"));
  const auto expected = std::size(kSchema) - (version < 4 ? 1 : 0);
  std::size_t count = 0;
  for (;; ++count) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, statement.step());
    if (!has_row) break;
    if (count >= expected || statement.text(0) != schema_of(version, kSchema[count]))
      return unusable_store_error(path_, "the tables of a store of samples", statement.text(0));
  }
  if (count == expected) return {};
  return unusable_store_error(path_, std::to_string(expected) + " tables and indexes",
                              std::to_string(count));
}

Status SampleStore::create_schema() {
  for (const auto sql : kSchema) DDSSEC_RETURN_IF_ERROR(database_.run(sql));
  DDSSEC_RETURN_IF_ERROR(database_.run("PRAGMA application_id=" + std::to_string(kApplicationId)));
  return database_.run("PRAGMA user_version=" + std::to_string(kVersion));
}

Status SampleStore::upgrade_schema(std::int64_t version) {
  if (version == kVersion) return {};
  for (const auto& [since, column] : kAddedColumns)
    if (version < since)
      DDSSEC_RETURN_IF_ERROR(database_.run("ALTER TABLE sample ADD COLUMN " + std::string(column)));
  if (version < 4) DDSSEC_RETURN_IF_ERROR(database_.run(kSchema[std::size(kSchema) - 1]));
  return database_.run("PRAGMA user_version=" + std::to_string(kVersion));
}

// A damaged row may have any content. It stays, and is refused when its stream is loaded.
Status SampleStore::erase_expired(Time now) {
  std::vector<std::int64_t> expired;
  {
    DDSSEC_ASSIGN_OR_RETURN(auto rows,
                            database_.prepare(std::string(kSelectSamples) + "WHERE expires <= ?"));
    rows.bind(1, now.to_nanoseconds().count());
    while (true) {
      DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
      if (!has_row) break;
      const auto sample = read_row(rows);
      if (sample && sample->expiry) expired.push_back(rows.number(0));
    }
  }
  if (expired.empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(auto transaction, Database::Transaction::begin(database_));
  for (const auto row : expired) DDSSEC_RETURN_IF_ERROR(erase_.bind(1, row).run());
  return transaction.commit();
}

Status SampleStore::erase_unused_streams() {
  const auto unused = fmt::format(
      "FROM stream WHERE {} AND NOT EXISTS (SELECT 1 FROM heard WHERE heard.stream = "
      "stream.id)",
      kWithoutSamples);
  DDSSEC_ASSIGN_OR_RETURN(const auto count, database_.number("SELECT count(*) " + unused));
  return count == 0 ? Status() : database_.run("DELETE " + unused);
}

Status SampleStore::forget_least_used_stream() {
  DDSSEC_ASSIGN_OR_RETURN(
      auto rows, database_.prepare(fmt::format("SELECT id FROM stream WHERE {} ORDER BY (SELECT "
                                               "max(used) FROM heard WHERE heard.stream = id)",
                                               kWithoutSamples)));
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
    if (!has_row)
      return fail(Code::rtps_store_failed, {.document = path_,
                                            .field = "writers",
                                            .expected = "at most " + std::to_string(kMaxStreams),
                                            .found = "one more"});
    const StreamId id{rows.number(0)};
    if (!streams_.contains(id)) return forget(id);
  }
}

Status SampleStore::forget(StreamId id) {
  DDSSEC_RETURN_IF_ERROR(heard_.forget(database_, id));
  return database_.run("DELETE FROM stream WHERE id = " + std::to_string(id.value));
}

Result<std::optional<StreamId>> SampleStore::row_of(const StreamKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto find,
      database_.prepare("SELECT id FROM stream WHERE domain = ? AND topic = ? AND type = ? AND "
                        "partition = ? AND ordinal = ?"));
  const auto partition = partition_octets(key);
  DDSSEC_ASSIGN_OR_RETURN(const auto has_row, bind_key(find, key, partition).step());
  if (has_row) return StreamId{find.number(0)};
  return std::nullopt;
}

Result<std::optional<StreamId>> SampleStore::find(const StreamKey& key) {
  {
    DDSSEC_ASSIGN_OR_RETURN(auto id, row_of(key));
    if (id) return id;
  }
  for (const auto& [id, stream] : streams_)
    if (stream.key == key) return id;
  return std::nullopt;
}

Status SampleStore::insert_row(StreamId id, const StreamKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto insert,
      database_.prepare("INSERT INTO stream(domain, topic, type, partition, ordinal, id) "
                        "VALUES(?, ?, ?, ?, ?, ?)"));
  const auto partition = partition_octets(key);
  return bind_key(insert, key, partition).bind(6, id.value).run();
}

Result<std::size_t> SampleStore::streams() {
  DDSSEC_ASSIGN_OR_RETURN(const auto rows, database_.number("SELECT count(*) FROM stream"));
  const auto without =
      std::ranges::count_if(streams_, [](const auto& entry) { return !entry.second.has_row; });
  return static_cast<std::size_t>(rows) + static_cast<std::size_t>(without);
}

Result<StreamId> SampleStore::stream(const StreamKey& key) {
  DDSSEC_ASSIGN_OR_RETURN(const auto id, find(key));
  if (id) {
    // This has no effect on a stream that is known without a row.
    streams_.try_emplace(*id, Stream{key, true});
    return *id;
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto stream_count, streams());
  if (stream_count >= kMaxStreams) DDSSEC_RETURN_IF_ERROR(forget_least_used_stream());
  const StreamId next{last_stream_ + 1};
  streams_.emplace(next, Stream{key});
  last_stream_ = next.value;
  return next;
}

Status SampleStore::close(StreamId id) {
  const auto at = streams_.find(id);
  if (at == streams_.end()) return {};
  const bool has_row = at->second.has_row;
  streams_.erase(at);
  if (!has_row) return {};
  return database_.run(
      fmt::format("DELETE FROM stream WHERE id = {0} AND {1} AND NOT EXISTS (SELECT 1 FROM heard "
                  "WHERE stream = {0})",
                  id.value, kWithoutSamples));
}

Status SampleStore::read_shares(StoreShares& shares) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto rows,
      database_.prepare(
          "SELECT identity, length(payload), count(*) FROM sample GROUP BY identity, 2"));
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
    if (!has_row) return {};

    const auto identity = identity_from(rows.octets(0));
    const auto cost = StoreShares::cost(static_cast<std::size_t>(rows.number(1)));
    const auto count = static_cast<std::size_t>(rows.number(2));
    if (identity) shares.add(shares.account(*identity), count * cost);
  }
}

Result<SampleStore::Pages> SampleStore::pages() {
  DDSSEC_ASSIGN_OR_RETURN(const auto page_count, database_.number("PRAGMA page_count"));
  DDSSEC_ASSIGN_OR_RETURN(const auto freelist_count, database_.number("PRAGMA freelist_count"));
  return Pages{static_cast<std::size_t>(page_count - freelist_count),
               static_cast<std::size_t>(freelist_count)};
}

Result<std::size_t> SampleStore::room() {
  DDSSEC_ASSIGN_OR_RETURN(const auto count, pages());
  const auto within_limit = (max_pages_ - std::min(count.used, max_pages_)) * kPageSize;
  if (path_.empty()) return within_limit;
  const auto on_disk = room_on_disk(path_, (count.used + count.unused) * kPageSize);
  return std::min(within_limit, on_disk + count.unused * kPageSize);
}

Status SampleStore::shorten_log() { return database_.run("PRAGMA wal_checkpoint(TRUNCATE)"); }

// Counts each octet twice: it is written to the log, and from there to a page of the file.
Status SampleStore::check_disk(std::span<const StoredChange> changes) {
  std::size_t wanted = 0;
  for (const auto& stored : changes)
    if (stored.row != 0) wanted += StoreShares::cost(stored.change.payload.size());
  if (wanted == 0 || path_.empty()) return {};
  std::size_t free = 0;
  for (const bool is_again : {false, true}) {
    if (is_again) DDSSEC_RETURN_IF_ERROR(shorten_log());
    DDSSEC_ASSIGN_OR_RETURN(const auto count, pages());
    const auto reused = std::min(wanted, count.unused * kPageSize);
    free = room_on_disk(path_, (count.used + count.unused) * kPageSize);
    if (free >= 2 * wanted - reused) return {};
  }
  return fail(Code::rtps_store_failed,
              {.document = path_,
               .field = "its disk",
               .expected = std::to_string(2 * wanted) + " octets, beside those that are kept free",
               .found = std::to_string(free)});
}

std::unexpected<Error> SampleStore::damaged_row_error(std::int64_t row) const {
  return unusable_store_error(path_, "what was stored",
                              "sample " + std::to_string(row) + " is damaged");
}

Result<StoredHistory> SampleStore::load(StreamId stream) {
  DDSSEC_ASSIGN_OR_RETURN(
      auto rows, database_.prepare(std::string(kSelectSamples) + "WHERE stream = ? ORDER BY id"));
  rows.bind(1, stream.value);
  StoredHistory out;
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(const auto has_row, rows.step());
    if (!has_row) break;

    auto sample = read_row(rows);
    if (!sample) return damaged_row_error(rows.number(0));
    out.changes.push_back(std::move(sample->change));
    out.rows.push_back(rows.number(0));
    out.identities.push_back(sample->identity);
    out.expiries.push_back(sample->expiry);
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto is_intact, heard_.load(database_, stream, out));
  if (!is_intact)
    return unusable_store_error(path_, "what was stored", "a writer that was heard is damaged");
  return out;
}

// If another program has filled the disk, the room of the log can be given back.
Status SampleStore::commit(std::span<const StoredChange> changes, Time now) {
  DDSSEC_RETURN_IF_ERROR(check_disk(changes));
  auto written = write(changes, now);
  if (!written && written.error().code() == Code::rtps_store_failed) {
    [[maybe_unused]] const auto shortened = shorten_log();
  }
  return written;
}

Status SampleStore::write(std::span<const StoredChange> changes, Time now) {
  std::vector<Stream*> made;
  // If the transaction fails, the counters of remembered writers are restored.
  Rollback undo([this, counters = heard_.counters()] { heard_.restore(counters); });
  {
    DDSSEC_ASSIGN_OR_RETURN(auto transaction, Database::Transaction::begin(database_));
    for (const auto& stored : changes) {
      const auto stream = streams_.find(stored.stream);
      if (stream == streams_.end()) continue;
      for (const auto row : stored.removed) DDSSEC_RETURN_IF_ERROR(erase_.bind(1, row).run());
      if (stored.row == 0) continue;
      if (!stream->second.has_row && std::ranges::find(made, &stream->second) == made.end()) {
        made.push_back(&stream->second);
        DDSSEC_RETURN_IF_ERROR(insert_row(stored.stream, stream->second.key));
      }
      DDSSEC_RETURN_IF_ERROR(insert(stored, now));
    }
    DDSSEC_RETURN_IF_ERROR(remember(changes));
    DDSSEC_RETURN_IF_ERROR(transaction.commit());
  }
  undo.release();
  for (auto* stream : made) stream->has_row = true;
  return {};
}

Status SampleStore::remember(std::span<const StoredChange> changes) {
  std::vector<const StoredChange*> known;
  for (const auto& stored : changes)
    if (streams_.contains(stored.stream)) known.push_back(&stored);
  return heard_.remember(database_, known);
}

Status SampleStore::insert(const StoredChange& stored, Time now) {
  auto change = stored.change;
  const auto key = change.key_hash.value_or(KeyHash{});
  const auto time = change.source_time.value_or(now);
  change.source_time = time;
  change.status.unregistered = false;
  const auto sum = sum_of(stored.row, stored.stream, change, stored.expiry);
  const auto origin = change.origin();
  const auto writer = origin.writer.octets();
  insert_.bind(1, stored.stream.value)
      .bind(2, BytesView(key))
      .bind(3, std::int64_t{change.key_hash.has_value()})
      .bind(4, std::int64_t{change.status.disposed})
      .bind(5, std::int64_t{time.seconds})
      .bind(6, std::int64_t{time.fraction})
      .bind(7, change.payload.view())
      .bind(8, BytesView(sum))
      .bind(9, stored.row)
      .bind(10, BytesView(writer))
      .bind(11, origin.number.value);
  if (stored.identity) insert_.bind(12, BytesView(stored.identity->octets));
  if (stored.expiry) insert_.bind(13, stored.expiry->at).bind(14, stored.expiry->lifespan);
  DDSSEC_RETURN_IF_ERROR(insert_.run());
  last_row_ = std::max(last_row_, stored.row);
  return {};
}

}  // namespace ddssec::rtps
