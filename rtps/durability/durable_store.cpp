#include "rtps/durability/durable_store.hpp"

#include <algorithm>
#include <system_error>

#include "base/background_thread.hpp"
#include "base/rollback.hpp"

namespace ddssec::rtps {
namespace {

// How long to wait before the next attempt, because a full disk may have room later.
constexpr std::chrono::milliseconds kRetry{200};
constexpr std::chrono::seconds kMaxOpen{5};
// How often to check the room while changes wait for it: other programs may have freed some of the
// disk.
constexpr std::chrono::seconds kRoomPollInterval{1};
constexpr std::uint32_t kMaxAlike = 64;

// Returns the octets that a commit handles for a change. A change without a payload costs about as
// much as a row that is removed, or an entry of an ended instance.
std::size_t work_of(const StoredChange& stored) {
  return stored.change.payload.size() +
         (1 + stored.removed.size() + stored.ends.size()) * DurableStore::kOctetsOfChange;
}

}  // namespace

Result<std::unique_ptr<DurableStore>> DurableStore::open(const std::string& path, EventSink& events,
                                                         std::size_t max_octets, Time now) {
  DDSSEC_ASSIGN_OR_RETURN(auto store, SampleStore::open(path, max_octets, now));
  std::unique_ptr<DurableStore> out(new DurableStore(std::move(store), events));
  DDSSEC_RETURN_IF_ERROR(out->start());
  return out;
}

DurableStore::DurableStore(SampleStore store, EventSink& events)
    : store_(std::move(store)), events_(events), index_(store_.last_row()) {}

Status DurableStore::start() {
  DDSSEC_RETURN_IF_ERROR(store_.read_shares(index_.shares()));
  DDSSEC_ASSIGN_OR_RETURN(room_, store_.room());
  index_.set_free(room_);
  try {
    thread_ = start_background_thread<std::thread>([this] { run(); });
  } catch (const std::system_error& error) {
    return fail(Code::rtps_thread_failed, {.document = "store", .found = error.what()});
  }
  return {};
}

DurableStore::~DurableStore() {
  {
    const std::lock_guard held(mutex_);
    is_stopping_ = true;
  }
  work_.notify_all();
  if (thread_.joinable()) thread_.join();
}

template <class Ready>
Status DurableStore::wait(std::chrono::nanoseconds timeout, Ready ready) {
  // A timeout that does not fit the clock is shortened to the longest wait.
  constexpr std::chrono::nanoseconds kMax = std::chrono::hours(24 * 365);
  std::unique_lock held(mutex_);
  const bool done =
      done_.wait_for(held, std::min(timeout, kMax), [&] { return ready() || !status_; });
  if (ready()) return {};
  if (done) return status_;
  return fail(Code::rtps_timeout, {.document = store_.path()});
}

Result<DurableStore::OpenedStream> DurableStore::open_stream(StreamKey key,
                                                             const DurabilityService& service,
                                                             const Moment& now, Duration lifespan) {
  std::unique_lock store(store_mutex_, kMaxOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  forget_closed();
  for (key.ordinal = 0; key.ordinal < kMaxAlike; ++key.ordinal) {
    DDSSEC_ASSIGN_OR_RETURN(const auto id, store_.stream(key));
    std::uint64_t before = 0;  // the last change of an earlier writer
    {
      const std::lock_guard held(mutex_);
      if (!open_.insert(id).second) continue;
      closed_.erase(id);
      if (const auto last = last_.find(id); last != last_.end()) before = last->second;
    }
    store.unlock();
    auto opened = load(id, service, before, now, lifespan);
    if (!opened) close_stream(id);
    return opened;
  }
  return fail(Code::rtps_store_failed, {.document = store_.path(),
                                        .field = "writers of topic " + key.topic,
                                        .expected = "at most " + std::to_string(kMaxAlike),
                                        .found = "one more"});
}

Result<bool> DurableStore::is_empty() {
  const std::unique_lock store(store_mutex_, kMaxOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  DDSSEC_ASSIGN_OR_RETURN(const auto count, store_.streams());
  return count == 0;
}

Result<DurableStore::OpenedStream> DurableStore::load(StreamId id, const DurabilityService& service,
                                                      std::uint64_t after, const Moment& now,
                                                      Duration lifespan) {
  DDSSEC_RETURN_IF_ERROR(wait(kMaxOpen, [&] { return committed_ >= after; }));
  const std::unique_lock store(store_mutex_, kMaxOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  DDSSEC_ASSIGN_OR_RETURN(auto history, store_.load(id));
  const std::lock_guard held(mutex_);
  const auto expires = index_.open(id, service, history, now, lifespan);
  const auto removed = clean_up(id, now, history.rows.size());
  const std::set<std::int64_t> gone(removed.begin(), removed.end());
  OpenedStream out{.id = id, .history = {}, .rows = {}, .heard = std::move(history.heard)};
  for (std::size_t i = 0; i < history.rows.size(); ++i) {
    if (gone.contains(history.rows[i])) continue;
    out.history.push_back(std::move(history.changes[i]));
    out.rows.push_back(history.rows[i]);
    out.expires.push_back(expires[i]);
  }
  return out;
}

void DurableStore::close_stream(StreamId stream) {
  const std::lock_guard held(mutex_);
  open_.erase(stream);
  closed_.insert(stream);
}

// If a row cannot be deleted now, it is deleted when the store is opened again.
void DurableStore::forget_closed() {
  std::vector<StreamId> gone;
  {
    const std::lock_guard held(mutex_);
    std::erase_if(closed_, [&](const auto stream) {
      const auto last = last_.find(stream);
      const bool is_over = last == last_.end() || last->second <= committed_;
      if (is_over) {
        gone.push_back(stream);
        index_.close(stream);
      }
      if (is_over && last != last_.end()) last_.erase(last);
      return is_over;
    });
  }
  for (const auto stream : gone) {
    [[maybe_unused]] const auto closed = store_.close(stream);
  }
}

DurableStore::AppendReport DurableStore::append(StoredChange change, const Moment& now) {
  const std::lock_guard held(mutex_);
  const auto identity = change.identity;
  if (identity && !may_append(*identity, change.change.payload.size())) return {};
  last_.try_emplace(change.stream);
  if (identity) octets_of_.try_emplace(*identity);
  {
    auto& stored = pending_.emplace_back(std::move(change));
    Rollback undo([&] { pending_.pop_back(); });
    AppendReport out{index_.add(stored, now)};
    if (out.outcome.decision != SampleIndex::Decision::waits) {
      undo.release();
      out.number = count_pending(now.wall);
      return out;
    }
  }
  // Changes that are being stored count twice until they are stored. Then there may be room.
  if (identity && pending_.empty() && appended_ == committed_) index_.shares().refuse(*identity);
  if (now.now >= look_at_room_at_) {
    look_at_room_at_ = now.now + kRoomPollInterval;
    looks_at_room_ = true;
  }
  if (looks_at_room_ || index_.shares().has_unreported()) work_.notify_one();
  return {.outcome = {}, .has_no_share = identity && octets_of_.find(*identity)->second == 0};
}

void DurableStore::refuse(const GuidPrefix& identity) {
  const std::lock_guard held(mutex_);
  index_.shares().refuse(identity);
  if (index_.shares().has_unreported()) work_.notify_one();
}

std::vector<std::int64_t> DurableStore::clean_up(StreamId stream, const Moment& now) {
  const std::lock_guard held(mutex_);
  return clean_up(stream, now, SampleIndex::kMaxRemoved);
}

MonotonicTime DurableStore::next_due(StreamId stream) const {
  const std::lock_guard held(mutex_);
  return index_.next_due(stream);
}

std::vector<std::int64_t> DurableStore::clean_up(StreamId stream, const Moment& now,
                                                 std::size_t max_samples) {
  if (index_.next_due(stream) > now.now) return {};
  last_.try_emplace(stream);
  auto& stored = pending_.emplace_back(StoredChange{stream});
  Rollback undo([&] { pending_.pop_back(); });
  auto removed = index_.clean_up(stored, now.now, max_samples);
  if (removed.empty()) return removed;
  undo.release();
  count_pending(now.wall);
  return removed;
}

bool DurableStore::may_append(const GuidPrefix& identity, std::size_t octets) const {
  const auto own = octets_of_.find(identity);
  return own == octets_of_.end() || own->second == 0 ||
         (!over() && own->second + octets + kOctetsOfChange <= kMaxPendingOctetsOfOne);
}

std::uint64_t DurableStore::count_pending(Time now) {
  const auto& last = pending_.back();
  octets_ += last.change.payload.size();
  if (last.identity) octets_of_.find(*last.identity)->second += work_of(last);
  now_ = now;
  last_.find(last.stream)->second = ++appended_;
  work_.notify_one();
  return appended_;
}

std::uint64_t DurableStore::committed() const {
  const std::lock_guard held(mutex_);
  return committed_;
}

std::uint64_t DurableStore::pending() const {
  const std::lock_guard held(mutex_);
  return appended_ - committed_;
}

std::uint64_t DurableStore::left_out() const {
  const std::lock_guard held(mutex_);
  return index_.left_out();
}

bool DurableStore::is_behind() const {
  const std::lock_guard held(mutex_);
  return over();
}

Status DurableStore::status() const {
  const std::lock_guard held(mutex_);
  return status_;
}

std::uint64_t DurableStore::groups() const {
  const std::lock_guard held(mutex_);
  return groups_;
}

Status DurableStore::flush(std::chrono::nanoseconds timeout) {
  std::uint64_t until = 0;
  {
    const std::lock_guard held(mutex_);
    until = appended_;
  }
  return wait(timeout, [&] { return committed_ >= until; });
}

Status DurableStore::wait_for_room(std::chrono::nanoseconds timeout) {
  return wait(timeout, [&] { return !over(); });
}

void DurableStore::run() {
  std::unique_lock held(mutex_);
  const auto has_work = [&] {
    return !pending_.empty() || !failed_.empty() || looks_at_room_ ||
           index_.shares().has_unreported();
  };
  for (;;) {
    work_.wait(held, [&] { return is_stopping_ || has_work(); });
    if (has_work()) commit(held);
    if (is_stopping_ && (!has_work() || !status_)) return;
    if (!status_) work_.wait_for(held, kRetry, [&] { return is_stopping_; });
  }
}

// An event that cannot be raised, for example because memory is short, must not end the thread.
void DurableStore::report(const Error* failure, std::uint64_t left_out,
                          const std::vector<StoreShares::Refusals>& refusals) noexcept try {
  if (failure != nullptr) events_.raise(Event(*failure));
  if (const auto more = left_out - std::exchange(left_out_, left_out); more != 0)
    events_.raise(Event(Error(Code::rtps_store_failed, {.document = store_.path(),
                                                        .field = "DURABILITY_SERVICE",
                                                        .expected = "samples within its limits",
                                                        .found = std::to_string(more) + " more"})));
  for (const auto& [identity, times] : refusals)
    events_.raise(Event(Error(
        Code::rtps_store_failed,
        {.document = store_.path(),
         .field = "share of the participants whose GUIDs begin with " +
                  to_hex(BytesView(identity.octets).first(6)),
         .expected = "at most as many octets as are free in the store, and as many samples of "
                     "a topic, or with OWNERSHIP EXCLUSIVE instances, as are free in it",
         .found =
             "a sample more, offered " + std::to_string(times) + (times == 1 ? " time" : " times"),
         .note = "it is not acknowledged and waits with its writer until there is room; another "
                 "event follows when samples were offered twice as often"})));
} catch (...) {
  return;
}

Status DurableStore::write(std::span<const StoredChange> group, Time now) {
  if (group.empty()) return {};
  try {
    return store_.commit(group, now);
  } catch (const std::exception&) {
    return fail(Code::out_of_memory);
  }
}

// A row that was removed is not needed by any later change. A removal whose row is not stored yet
// has no effect now, and is repeated in its turn.
std::vector<StoredChange> DurableStore::removals_before(
    std::vector<StoredChange>& group) const noexcept try {
  std::vector<StoredChange> out;
  std::set<std::int64_t> gone;
  for (const auto* changes : {&std::as_const(group), &pending_})
    for (const auto& stored : *changes) {
      if (stored.row != 0 || !stored.change.is_alive() || stored.removed.empty()) continue;
      gone.insert(stored.removed.begin(), stored.removed.end());
      out.push_back({.stream = stored.stream, .removed = stored.removed});
    }
  for (auto& stored : group)
    if (gone.contains(stored.row)) stored.row = 0;
  return out;
} catch (const std::exception&) {
  return {};
}

// Returns the room now; empty if there was no memory to determine it.
std::optional<std::size_t> DurableStore::room_now() noexcept try {
  const auto room = store_.room();
  return room ? std::optional(*room) : std::nullopt;
} catch (const std::bad_alloc&) {
  return std::nullopt;
}

void DurableStore::set_free() {
  const auto octets =
      octets_ + failed_octets_ + (pending_.size() + failed_.size()) * StoreShares::cost(0);
  index_.set_free(room_ - std::min(room_, 2 * octets));
}

// A group that fails is kept and committed before later ones.
void DurableStore::commit(std::unique_lock<std::mutex>& held) {
  std::vector<StoredChange> group;
  const bool is_again = !failed_.empty();
  group.swap(is_again ? failed_ : pending_);
  const auto octets = std::exchange(is_again ? failed_octets_ : octets_, 0);
  const auto removals = is_again ? removals_before(group) : std::vector<StoredChange>{};
  const auto now = now_;
  const auto left_out = index_.left_out();
  const auto refusals = index_.shares().take_unreported();
  looks_at_room_ = false;
  held.unlock();
  std::unique_lock store(store_mutex_);
  auto written = write(removals, now);
  if (written) written = write(group, now);
  const auto room = room_now();
  store.unlock();
  report(!written && status_ ? &written.error() : nullptr, left_out, refusals);
  held.lock();
  status_ = std::move(written);
  if (status_) {
    for (const auto& stored : group)
      if (stored.identity) octets_of_.find(*stored.identity)->second -= work_of(stored);
    committed_ += group.size();
    groups_ += group.empty() ? 0 : 1;
    if (room) room_ = *room;
  } else {
    failed_.swap(group);
    failed_octets_ = octets;
  }
  set_free();
  done_.notify_all();
}

}  // namespace ddssec::rtps
