#include "rtps/memory/descriptor_passing.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <dlfcn.h>
#include <new>
#include <sys/eventfd.h>
#include <system_error>
#include <thread>
#include <variant>

#include "base/background_thread.hpp"
#include "rtps/memory/memory_room.hpp"

namespace ddssec::rtps::memory {
namespace {

// If the thread is busy with one turn for this long, it counts as held up.
constexpr MonotonicTime kHeldUp = std::chrono::seconds(1);
constexpr std::size_t kMaxAtOnce = 16;

struct Fetch {
  DescriptorOffer offer;
};
struct Make {
  std::uint64_t segment = 0;
  std::size_t largest = 0;
};
struct Wipe {
  SampleSlots slots;
};
struct Work {
  std::uint64_t id = 0;
  std::variant<Fetch, Make, Wipe> what;
};

struct Request {
  std::uint64_t id = 0;
  DescriptorRequest request;
  MonotonicTime until{};
};

MonotonicTime now_of_thread() { return std::chrono::steady_clock::now().time_since_epoch(); }

void signal(const FileDescriptor& event) {
  const std::uint64_t one = 1;
  // If the counter is full, the event is readable already.
  if (::write(event.number(), &one, sizeof one) < 0) return;
}

void drain(const FileDescriptor& event) {
  std::uint64_t count = 0;
  if (::read(event.number(), &count, sizeof count) < 0) return;
}

FileDescriptor new_event() { return FileDescriptor(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)); }

// Keeps the library loaded if the program unloads it, because a thread that is held up still needs
// its code.
void keep_code() {
  Dl_info info{};
  if (::dladdr(static_cast<const void*>(&kHeldUp), &info) == 0 || info.dli_fname == nullptr) return;
  // The handle is never closed, on purpose.
  static_cast<void>(::dlopen(info.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_NODELETE));
}

MemoryResult<SampleSlots> slots_of(const Make& make) {
  if (!has_memory_room(SampleSlots::size_for(make.largest))) return refuse(MemoryRefusal::no_room);
  return SampleSlots::make(make.segment, make.largest);
}

}  // namespace

struct DescriptorPassing::Shared {
  Shared(DescriptorServer of_writers, Users admitted)
      : server(std::move(of_writers)), users(admitted) {}

  // Does one turn of work. With `wait`, it first waits until there is any.
  void turn(MonotonicTime now, bool wait);
  void run();
  void wait_for_work(MonotonicTime now);
  void begin(Work work, MonotonicTime now);
  void fetch(std::uint64_t id, const DescriptorOffer& offer, MonotonicTime now);
  // Returns true if the request has ended.
  bool look_at(Request& request, MonotonicTime now);
  // Returns the next work. Without `fetches`, only work that no other process can delay.
  std::optional<Work> next_work(bool fetches);
  template <class T, class R>
  void give(std::vector<T>& results, std::uint64_t id, R result);
  bool accepts_work() const;
  MemoryResult<std::uint64_t> add(decltype(Work::what) what);
  std::uint64_t push(decltype(Work::what) what);
  bool is_held_up() const;

  // Only the thread uses these:
  DescriptorServer server;  // both sides use its offers
  const Users users;
  std::vector<Request> requests;
  std::vector<pollfd> waiting;

  const FileDescriptor wake = new_event(), ready = new_event();
  std::atomic<bool> ends = false;
  // The time at which the thread began its current work; 0 while it waits.
  std::atomic<MonotonicTime::rep> busy_since = 0;

  mutable std::mutex lock;  // protects all below; no call that could wait is made with it
  std::deque<Work> work;
  std::vector<FetchedSegment> fetched;
  std::vector<PreparedSlots> prepared;
  std::size_t unfinished = 0;  // work whose results were not taken yet
  std::uint64_t last_id = 0;
  bool has_thread = false, refuses = false, has_ended = false;
  std::condition_variable ended;
};

// ---- the thread

void DescriptorPassing::Shared::run() {
  while (!ends) {
    wait_for_work(now_of_thread());
    busy_since = now_of_thread().count();
    try {
      if (!ends) turn(now_of_thread(), true);
    } catch (const std::bad_alloc&) {
      // There was no memory even for a result, so the writer continues by UDP.
    }
    busy_since = 0;
  }
  requests.clear();
  // Closes the connections of strangers, with what they sent.
  { const auto last = std::move(server); }
  const std::lock_guard held(lock);
  has_ended = true;
  ended.notify_all();
}

void DescriptorPassing::Shared::wait_for_work(MonotonicTime now) {
  waiting.clear();
  waiting.push_back({.fd = wake.number(), .events = POLLIN, .revents = 0});
  server.watch(waiting);
  auto until = server.deadline();
  for (const auto& each : requests) {
    waiting.push_back({.fd = each.request.descriptor(), .events = POLLIN, .revents = 0});
    until = until ? std::min(*until, each.until) : each.until;
  }
  const auto rest = until ? std::max(*until - now, MonotonicTime::zero()) : MonotonicTime::zero();
  const auto milliseconds = std::chrono::ceil<std::chrono::milliseconds>(rest).count();
  ::poll(waiting.data(), waiting.size(), until ? static_cast<int>(milliseconds) : -1);
  drain(wake);
}

void DescriptorPassing::Shared::turn(MonotonicTime now, bool wait) {
  while (auto next = next_work(requests.size() < kMaxAtOnce)) {
    const auto id = next->id;
    const bool is_fetch = std::holds_alternative<Fetch>(next->what);
    try {
      begin(*std::move(next), now);
    } catch (const std::bad_alloc&) {
      if (is_fetch)
        give(fetched, id, MemoryResult<MappedSegment>(refuse(MemoryRefusal::no_memory)));
      else
        give(prepared, id, MemoryResult<SampleSlots>(refuse(MemoryRefusal::no_memory)));
    }
    if (wait) busy_since = now_of_thread().count();
  }
  server.serve(now);
  std::erase_if(requests, [&](Request& each) { return look_at(each, now); });
}

std::optional<Work> DescriptorPassing::Shared::next_work(bool fetches) {
  const std::lock_guard held(lock);
  const auto at = std::ranges::find_if(
      work, [&](const Work& one) { return fetches || !std::holds_alternative<Fetch>(one.what); });
  if (at == work.end()) return std::nullopt;
  auto out = std::move(*at);
  work.erase(at);
  return out;
}

void DescriptorPassing::Shared::begin(Work next, MonotonicTime now) {
  if (auto* const it = std::get_if<Fetch>(&next.what)) fetch(next.id, it->offer, now);
  if (auto* const it = std::get_if<Make>(&next.what)) give(prepared, next.id, slots_of(*it));
  if (auto* const it = std::get_if<Wipe>(&next.what)) {
    it->slots.wipe();
    give(prepared, next.id, MemoryResult<SampleSlots>(std::move(it->slots)));
  }
}

void DescriptorPassing::Shared::fetch(std::uint64_t id, const DescriptorOffer& offer,
                                      MonotonicTime now) {
  auto sent = DescriptorRequest::send(offer, users);
  if (!sent) return give(fetched, id, MemoryResult<MappedSegment>(refuse(sent.error())));
  requests.push_back({id, *std::move(sent), now + kMaxRequest});
}

bool DescriptorPassing::Shared::look_at(Request& request, MonotonicTime now) {
  auto taken = request.request.take();
  const bool is_there = !taken || *taken;
  if (!is_there && now < request.until) return false;
  MemoryResult<MappedSegment> out = refuse(MemoryRefusal::no_answer);
  if (!taken) out = refuse(taken.error());
  if (taken && *taken) out = **std::move(taken);
  give(fetched, request.id, std::move(out));
  return true;
}

template <class T, class R>
void DescriptorPassing::Shared::give(std::vector<T>& results, std::uint64_t id, R result) {
  {
    const std::lock_guard held(lock);
    results.push_back({id, std::move(result)});
  }
  signal(ready);
}

// ---- the participant's side

MemoryResult<std::unique_ptr<DescriptorPassing>> DescriptorPassing::make(Random& random,
                                                                         Users users) {
  auto server = DescriptorServer::listen(random, users);
  if (!server) return refuse(server.error());
  auto shared = std::make_shared<Shared>(*std::move(server), users);
  if (!shared->wake || !shared->ready) return refuse(MemoryRefusal::no_socket);
  return std::unique_ptr<DescriptorPassing>(new DescriptorPassing(std::move(shared)));
}

bool DescriptorPassing::start() {
  const std::lock_guard held(shared_->lock);
  try {
    start_background_thread<std::thread>([shared = shared_] { shared->run(); }).detach();
    shared_->has_thread = true;
  } catch (const std::system_error&) {
    shared_->refuses = true;
  }
  return shared_->has_thread;
}

// If the thread is held up, it ends when it can. It owns everything that it uses.
DescriptorPassing::~DescriptorPassing() {
  shared_->ends = true;
  signal(shared_->wake);
  std::unique_lock held(shared_->lock);
  if (!shared_->has_thread) return;
  if (!shared_->ended.wait_for(held, kMaxEnd, [&] { return shared_->has_ended; })) keep_code();
}

void DescriptorPassing::serve(MonotonicTime now) {
  offers().forget_late(now);
  bool has_thread = false;
  {
    const std::lock_guard held(shared_->lock);
    has_thread = shared_->has_thread || shared_->refuses;
  }
  if (!has_thread) shared_->turn(now, false);
  drain(shared_->ready);
}

int DescriptorPassing::descriptor() const { return shared_->ready.number(); }

bool DescriptorPassing::Shared::is_held_up() const {
  const auto since = busy_since.load();
  return since != 0 && now_of_thread() - MonotonicTime(since) > kHeldUp;
}

MemoryResult<DescriptorOffer> DescriptorPassing::offer(const Segment& segment, Random& random,
                                                       MonotonicTime now, std::string identity) {
  if (shared_->is_held_up() || closes_too_many()) return refuse(MemoryRefusal::held_up);
  return shared_->server.offer(segment, random, now, std::move(identity));
}

OpenOffers& DescriptorPassing::offers() { return shared_->server.offers(); }
const OpenOffers& DescriptorPassing::offers() const { return shared_->server.offers(); }

bool DescriptorPassing::Shared::accepts_work() const {
  const std::lock_guard held(lock);
  return unfinished < kMaxWork && !refuses && !is_held_up();
}

std::uint64_t DescriptorPassing::Shared::push(decltype(Work::what) what) {
  std::uint64_t id = 0;
  {
    const std::lock_guard held(lock);
    ++unfinished;
    id = ++last_id;
    work.push_back({id, std::move(what)});
  }
  signal(wake);
  return id;
}

MemoryResult<std::uint64_t> DescriptorPassing::Shared::add(decltype(Work::what) what) {
  if (!accepts_work()) return refuse(MemoryRefusal::held_up);
  return push(std::move(what));
}

bool DescriptorPassing::accepts_work() const { return shared_->accepts_work(); }

MemoryResult<std::uint64_t> DescriptorPassing::fetch(DescriptorOffer offer) {
  return shared_->add(Fetch{std::move(offer)});
}

MemoryResult<std::uint64_t> DescriptorPassing::make_slots(std::uint64_t segment,
                                                          std::size_t largest) {
  return shared_->add(Make{segment, largest});
}

std::uint64_t DescriptorPassing::wipe(SampleSlots slots) {
  return shared_->push(Wipe{std::move(slots)});
}

std::vector<DescriptorPassing::FetchedSegment> DescriptorPassing::take_fetched() {
  const std::lock_guard held(shared_->lock);
  shared_->unfinished -= shared_->fetched.size();
  return std::exchange(shared_->fetched, {});
}

std::vector<DescriptorPassing::PreparedSlots> DescriptorPassing::take_prepared() {
  const std::lock_guard held(shared_->lock);
  shared_->unfinished -= shared_->prepared.size();
  return std::exchange(shared_->prepared, {});
}

}  // namespace ddssec::rtps::memory
