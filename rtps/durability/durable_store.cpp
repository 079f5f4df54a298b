#include "rtps/durability/durable_store.hpp"

#include <algorithm>
#include <system_error>

#include "base/background_thread.hpp"

namespace ddssec::rtps {
namespace {

// A full disk may have room later.
constexpr std::chrono::milliseconds kRetry{200};
constexpr std::chrono::seconds kLongestOpen{5};
constexpr std::uint32_t kMostAlike = 64;

void take_one(std::map<GuidPrefix, std::size_t>& counts, const GuidPrefix& identity) {
  if (const auto at = counts.find(identity); at != counts.end() && --at->second == 0)
    counts.erase(at);
}

}  // namespace

Result<std::unique_ptr<DurableStore>> DurableStore::open(const std::string& path, EventSink& events,
                                                         std::size_t most_octets) {
  DDSSEC_ASSIGN_OR_RETURN(auto store, SampleStore::open(path, most_octets));
  std::unique_ptr<DurableStore> out(new DurableStore(std::move(store), events));
  DDSSEC_RETURN_IF_ERROR(out->start());
  return out;
}

DurableStore::DurableStore(SampleStore store, EventSink& events)
    : store_(std::move(store)), events_(events) {}

Status DurableStore::start() {
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
    stopping_ = true;
  }
  work_.notify_all();
  if (thread_.joinable()) thread_.join();
}

template <class Ready>
Status DurableStore::wait(std::chrono::nanoseconds most, Ready ready) {
  // A time that does not fit the clock is shortened to the longest wait.
  constexpr std::chrono::nanoseconds kLongest = std::chrono::hours(24 * 365);
  std::unique_lock held(mutex_);
  const bool done =
      done_.wait_for(held, std::min(most, kLongest), [&] { return ready() || !status_; });
  if (ready()) return {};
  if (done) return status_;
  return fail(Code::rtps_timeout, {.document = store_.path()});
}

Result<DurableStore::Opened> DurableStore::open_stream(StreamKey key,
                                                       const DurabilityService& service,
                                                       bool watch) {
  std::unique_lock store(store_mutex_, kLongestOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  forget_closed();
  for (key.ordinal = 0; key.ordinal < kMostAlike; ++key.ordinal) {
    DDSSEC_ASSIGN_OR_RETURN(const auto id, store_.stream(key, service));
    std::uint64_t before = 0;  // what an earlier writer appended
    {
      const std::lock_guard held(mutex_);
      if (!open_.insert(id).second) continue;
      closed_.erase(id);
      if (const auto last = last_.find(id); last != last_.end()) before = last->second;
    }
    store.unlock();
    auto opened = load(id, before, watch);
    if (!opened) close_stream(id);
    return opened;
  }
  return fail(Code::rtps_store_failed, {.document = store_.path(),
                                        .field = "writers of topic " + key.topic,
                                        .expected = "at most " + std::to_string(kMostAlike),
                                        .found = "one more"});
}

Result<bool> DurableStore::is_empty() {
  const std::unique_lock store(store_mutex_, kLongestOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  DDSSEC_ASSIGN_OR_RETURN(const auto count, store_.streams());
  return count == 0;
}

Result<DurableStore::Opened> DurableStore::load(StreamId id, std::uint64_t after, bool watch) {
  DDSSEC_RETURN_IF_ERROR(wait(kLongestOpen, [&] { return committed_ >= after; }));
  const std::unique_lock store(store_mutex_, kLongestOpen);
  if (!store) return fail(Code::rtps_timeout, {.document = store_.path()});
  if (watch) store_.watch(id);
  DDSSEC_ASSIGN_OR_RETURN(auto history, store_.load(id));
  return Opened{id, std::move(history.changes), std::move(history.rows)};
}

std::vector<StoreEffect> DurableStore::take_effects(StreamId stream) {
  const std::lock_guard held(mutex_);
  const auto at = effects_.find(stream);
  if (at == effects_.end()) return {};
  auto out = std::move(at->second);
  effects_.erase(at);
  return out;
}

// The thread must not end, and the owner of a stream must learn every effect.
void DurableStore::note(std::unique_lock<std::mutex>& held,
                        const std::vector<StoreEffect>& effects) {
  for (auto at = effects.begin(); at != effects.end();) try {
      if (open_.contains(at->stream)) effects_[at->stream].push_back(*at);
      ++at;
    } catch (const std::bad_alloc&) {
      work_.wait_for(held, kRetry);
    }
}

void DurableStore::close_stream(StreamId stream) {
  const std::lock_guard held(mutex_);
  open_.erase(stream);
  if (const auto effects = effects_.extract(stream))
    for (const auto& effect : effects.mapped())
      if (effect.is_refused) take_one(refused_, effect.identity);
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
      if (is_over) gone.push_back(stream);
      if (is_over && last != last_.end()) last_.erase(last);
      return is_over;
    });
  }
  for (const auto stream : gone) {
    [[maybe_unused]] const auto closed = store_.close(stream);
  }
}

std::uint64_t DurableStore::append(StreamId stream, const Change& change, Time now,
                                   const std::optional<GuidPrefix>& identity, bool was_refused) {
  std::uint64_t number = 0;
  {
    const std::lock_guard held(mutex_);
    pending_.push_back({stream, change, identity, was_refused});
    octets_ += change.payload.size();
    now_ = now;
    number = ++appended_;
    last_[stream] = number;
  }
  work_.notify_one();
  return number;
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
  return left_out_;
}

bool DurableStore::is_crowded(const GuidPrefix& identity) const {
  const std::lock_guard held(mutex_);
  return crowded_.contains(identity);
}

bool DurableStore::has_refused(const GuidPrefix& identity) const {
  const std::lock_guard held(mutex_);
  return refused_.contains(identity);
}

void DurableStore::give_up_refused(const GuidPrefix& identity) {
  const std::lock_guard held(mutex_);
  take_one(refused_, identity);
}

// As in note(): the thread must not end. What belongs to a stream that was closed is given up.
void DurableStore::count_refused(std::unique_lock<std::mutex>& held,
                                 const std::vector<StoredChange>& group,
                                 const std::vector<StoreEffect>& effects) {
  const auto matters = [](const auto& one) { return one.is_refused; };
  if (std::ranges::none_of(effects, matters) &&
      std::ranges::none_of(group, &StoredChange::was_refused))
    return;
  for (;;) try {
      auto next = refused_;
      for (const auto& effect : effects)
        if (effect.is_refused && open_.contains(effect.stream)) ++next[effect.identity];
      for (const auto& change : group)
        if (change.was_refused && change.identity) take_one(next, *change.identity);
      refused_.swap(next);
      return;
    } catch (const std::bad_alloc&) {
      work_.wait_for(held, kRetry);
    }
}

void DurableStore::look_for_room(Time now) {
  {
    const std::lock_guard held(mutex_);
    now_ = now;
    is_looking_ = true;
  }
  work_.notify_one();
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

Status DurableStore::flush(std::chrono::nanoseconds most) {
  std::uint64_t until = 0;
  {
    const std::lock_guard held(mutex_);
    until = appended_;
  }
  return wait(most, [&] { return committed_ >= until; });
}

Status DurableStore::wait_for_room(std::chrono::nanoseconds most) {
  return wait(most, [&] { return !over(); });
}

void DurableStore::run() {
  std::unique_lock held(mutex_);
  const auto has_work = [&] { return !pending_.empty() || !failed_.empty() || is_looking_; };
  for (;;) {
    work_.wait(held, [&] { return stopping_ || has_work(); });
    if (has_work()) commit(held);
    if (stopping_ && (!has_work() || !status_)) return;
    if (!status_) work_.wait_for(held, kRetry, [&] { return stopping_; });
  }
}

// An event that cannot be raised, for example without memory, must not end the thread.
void DurableStore::report(const Error* failure, std::uint64_t beyond_limits,
                          const std::vector<StoreShares::Refusals>& refusals) noexcept try {
  if (failure != nullptr) events_.raise(Event(*failure));
  if (const auto more = beyond_limits - std::exchange(beyond_limits_, beyond_limits); more != 0)
    events_.raise(Event(Error(Code::rtps_store_failed, {.document = store_.path(),
                                                        .field = "DURABILITY_SERVICE",
                                                        .expected = "samples within its limits",
                                                        .found = std::to_string(more) + " more"})));
  for (const auto& [identity, samples] : refusals)
    events_.raise(Event(Error(
        Code::rtps_store_failed,
        {.document = store_.path(),
         .field = "share of the participants whose GUIDs begin with " +
                  to_hex(BytesView(identity.octets).first(6)),
         .expected = "at most as many octets as are free in the store, and as many samples of "
                     "a topic as are free in it",
         .found = std::to_string(samples) + " samples more",
         .note = "they are not acknowledged and wait for room; another event follows when they are "
                 "twice as many"})));
} catch (...) {
  return;
}

Status DurableStore::write(std::span<const StoredChange> group, Time now) {
  try {
    return store_.commit(group, now);
  } catch (const std::exception&) {
    return fail(Code::out_of_memory);
  }
}

/// Empty: there was no memory to find out.
std::optional<std::set<GuidPrefix>> DurableStore::crowded_now() noexcept try {
  return store_.shares().crowded();
} catch (const std::bad_alloc&) {
  return std::nullopt;
}

// A group that fails is kept and committed before later ones.
void DurableStore::commit(std::unique_lock<std::mutex>& held) {
  std::vector<StoredChange> group;
  const bool is_again = !failed_.empty();
  group.swap(is_again ? failed_ : pending_);
  const auto octets = std::exchange(is_again ? failed_octets_ : octets_, 0);
  const auto now = now_;
  is_looking_ = false;
  held.unlock();
  std::unique_lock store(store_mutex_);
  auto written = write(group, now);
  const auto left_out = store_.left_out();
  const auto refusals = store_.shares().take_news();
  auto crowded = crowded_now();
  const auto effects = store_.take_effects();
  store.unlock();
  report(!written && status_ ? &written.error() : nullptr, left_out, refusals);
  held.lock();
  left_out_ = left_out;
  if (crowded) crowded_.swap(*crowded);
  status_ = std::move(written);
  if (status_) {
    count_refused(held, group, effects);
    note(held, effects);
    committed_ += group.size();
    ++groups_;
  } else {
    failed_.swap(group);
    failed_octets_ = octets;
  }
  done_.notify_all();
}

}  // namespace ddssec::rtps
