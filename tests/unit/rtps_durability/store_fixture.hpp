// A folder of its own for each test, and samples whose content shows their number.
#pragma once

#include <filesystem>
#include <unistd.h>

#include <gtest/gtest.h>

#include "base/rollback.hpp"
#include "rtps/durability/durable_store.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps::testing {

struct StoreTest : ::testing::Test {
  StoreTest() {
    std::filesystem::create_directory(folder);
    std::filesystem::permissions(folder, std::filesystem::perms::owner_all);  // whatever the umask
  }
  ~StoreTest() override { std::filesystem::remove_all(folder); }

  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("ddssec-store-" + std::to_string(::getpid()));
  const std::string path = folder / "samples";
};

inline Time seconds(std::int32_t count) { return Time{{count, 0}}; }
/// Returns a moment at which both clocks show this time.
inline Moment on_both(Time time) { return {time.to_nanoseconds(), time}; }
inline Moment at(std::int32_t count) { return on_both(seconds(count)); }

/// A store with its index, as DurableStore has them, without its thread.
class IndexedStore {
 public:
  static Result<IndexedStore> open(const std::string& path,
                                   std::size_t max_octets = SampleStore::kDefaultOctets) {
    DDSSEC_ASSIGN_OR_RETURN(auto store, SampleStore::open(path, max_octets));
    IndexedStore out(std::move(store));
    DDSSEC_RETURN_IF_ERROR(out.store.read_shares(out.index.shares()));
    DDSSEC_ASSIGN_OR_RETURN(const auto room, out.store.room());
    out.index.set_free(room);
    return out;
  }
  Result<StreamId> stream(const StreamKey& key, const DurabilityService& service) {
    DDSSEC_ASSIGN_OR_RETURN(const auto id, store.stream(key));
    DDSSEC_ASSIGN_OR_RETURN(const auto history, store.load(id));
    index.open(id, service, history, opened_at);
    return id;
  }
  Status close(StreamId stream) {
    index.close(stream);
    return store.close(stream);
  }
  /// Stores the changes, except those that wait for room. After an error, the next call stores
  /// them.
  Status commit(const std::vector<StoredChange>& changes, const Moment& now) {
    for (const auto& change : changes) {
      pending.push_back(change);
      Rollback undo([&] { pending.pop_back(); });
      const auto outcome = index.add(pending.back(), now);
      if (outcome.decision == SampleIndex::Decision::waits)
        ++waited;
      else
        undo.release();
      outcomes.push_back(outcome);
    }
    return write(now.wall);
  }
  Status commit(const std::vector<StoredChange>& changes, Time now) {
    return commit(changes, on_both(now));
  }
  /// Removes everything that is due at `now` on both clocks.
  Status clean_up(StreamId stream, Time now) {
    do {
      pending.push_back({stream});
    } while (!index.clean_up(pending.back(), on_both(now).now).empty());
    return write(now);
  }
  std::size_t size(StreamId stream) const { return index.size(stream); }
  std::uint64_t left_out() const { return index.left_out(); }

  SampleStore store;
  Moment opened_at = at(1000);
  SampleIndex index{store.last_row()};
  std::vector<StoredChange> pending = {};
  std::vector<SampleIndex::AddResult> outcomes = {};
  std::size_t waited = 0;

 private:
  explicit IndexedStore(SampleStore opened) : store(std::move(opened)) {}
  Status write(Time now) {
    DDSSEC_RETURN_IF_ERROR(store.commit(pending, now));
    pending.clear();
    DDSSEC_ASSIGN_OR_RETURN(const auto room, store.room());
    index.set_free(room);
    return {};
  }
};

inline const StreamKey kMap{.domain = 140, .topic = "Map", .type = "Grid"};

inline DurabilityService keep_all() {
  DurabilityService service;
  service.history.kind = HistoryKind::keep_all;
  return service;
}
inline DurabilityService keep_last(std::int32_t depth) {
  DurabilityService service;
  service.history.depth = depth;
  return service;
}

/// Returns the n-th sample: of instance n % instances, with octets that are derived from n.
inline Change sample(std::uint32_t number, std::uint32_t instances = 1) {
  Change change;
  change.key_hash.emplace().fill(static_cast<std::uint8_t>(number % instances));
  change.source_time = seconds(static_cast<std::int32_t>(number));
  Bytes octets(8 + number % 50, static_cast<std::uint8_t>(number * 7));
  for (int i = 0; i < 4; ++i)
    octets[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(number >> (8 * i));
  change.payload = Payload::copy_of(octets);
  return change;
}
inline Change dispose(std::uint32_t instance) {
  auto change = sample(instance, instance + 1);
  change.status.disposed = true;
  change.is_key_only = true;
  return change;
}
/// Returns the number of a sample, or nothing if its content was changed.
inline std::optional<std::uint32_t> number_of(const Change& change, std::uint32_t instances = 1) {
  const auto octets = change.payload.view();
  if (octets.size() < 8) return std::nullopt;
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number |= std::uint32_t{octets[i]} << (8 * i);
  const auto made = sample(number, instances);
  const bool same = std::ranges::equal(made.payload.view(), octets) &&
                    made.key_hash == change.key_hash && made.source_time == change.source_time;
  return same ? std::optional(number) : std::nullopt;
}
inline std::vector<std::uint32_t> numbers(const std::vector<Change>& changes,
                                          std::uint32_t instances = 1) {
  std::vector<std::uint32_t> out;
  for (const auto& change : changes) out.push_back(number_of(change, instances).value_or(~0u));
  return out;
}

}  // namespace ddssec::rtps::testing
