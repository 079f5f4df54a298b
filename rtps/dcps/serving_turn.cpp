#include "rtps/dcps/serving_turn.hpp"

#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include "rtps/dcps/condition_state.hpp"

namespace ddssec::rtps {

ServingTurn::ServingTurn(Server& server)
    : server_(server), timer_(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK)) {
  if (timer_.number() < 0) own_until_ = Clock::time_point::max();
}

ServingTurn::WaitScope::WaitScope(ServingTurn& turn, WaitReason reason,
                                  std::shared_ptr<WaitSetState> set)
    : turn_(turn), may_serve_(reason == WaitReason::data), set_(std::move(set)) {
  const auto now = Clock::now();
  const std::lock_guard held(turn.mutex_);
  turn.returns_soon_ = now - turn.last_end_ < kGrace;
  turn.add(*this);
  if (turn.count_ == 1 && may_serve_) return;
  // If each thread served for itself alone, the others would be without service at times.
  turn.own_until_ = std::max(turn.own_until_, now + (may_serve_ ? kAfterListeners : kAfterBulk));
  if (turn.holder_ == Holder::none) turn.arm(std::chrono::nanoseconds::zero());
}

ServingTurn::WaitScope::~WaitScope() {
  const auto now = Clock::now();
  const std::lock_guard held(turn_.mutex_);
  turn_.note_displaced(*this);
  turn_.remove(*this);
  turn_.last_end_ = now;
  if (serves_) turn_.give_up(now);
}

bool ServingTurn::WaitScope::serves() {
  if (!may_serve_) return false;
  const auto now = Clock::now();
  const std::lock_guard held(turn_.mutex_);
  turn_.note_displaced(*this);
  const bool may = !turn_.is_closed_ && now >= turn_.own_until_;
  if (serves_ && !may) {
    serves_ = false;
    turn_.give_up(now);
  }
  if (serves_ || !may || !turn_.may_begin(now)) return serves_;
  turn_.leader_ = this;
  progress_ = turn_.progress_ += 2;
  return serves_ = true;
}

bool ServingTurn::may_begin(Clock::time_point now) {
  if (holder_ != Holder::none || count_ != 1) return false;
  holder_ = Holder::application;
  is_due_at_once_ = false;
  // At a low rate, it costs less to stop the timer than to let it wake the participant's thread.
  if (is_armed_ && now - last_turn_ > kGrace) arm(std::chrono::nanoseconds::max());
  last_turn_ = now;
  return true;
}

void ServingTurn::note_displaced(WaitScope& waiting) {
  if (!waiting.serves_ || leader_ == &waiting) return;
  waiting.serves_ = false;
  if (--displaced_ == 0) given_up_.notify_all();
}

void ServingTurn::add(WaitScope& waiting) {
  waiting.next_ = std::exchange(list_, &waiting);
  ++count_;
}

void ServingTurn::remove(WaitScope& waiting) {
  auto** at = &list_;
  while (*at != &waiting) at = &(*at)->next_;
  *at = waiting.next_;
  --count_;
}

void ServingTurn::give_up(Clock::time_point now) {
  holder_ = Holder::none;
  leader_ = nullptr;
  given_up_at_ = now;
  if (is_closed_) given_up_.notify_all();
  if (is_closed_ || now < own_until_ || count_ > 0)
    arm(std::chrono::nanoseconds::zero());
  else if (!is_armed_)
    arm(kGrace);
}

// Sets the timer. Zero means at once, and the greatest value never.
void ServingTurn::arm(std::chrono::nanoseconds after) {
  is_armed_ = after != std::chrono::nanoseconds::max();
  is_due_at_once_ = after == std::chrono::nanoseconds::zero();
  itimerspec when{};
  if (is_armed_) when.it_value.tv_nsec = std::max<std::int64_t>(after.count(), 1);
  ::timerfd_settime(timer_.number(), 0, &when, nullptr);
}

bool ServingTurn::await() {
  Watch watch;
  for (bool fired = true;; fired = sleep()) {
    const auto now = Clock::now();
    const std::lock_guard held(mutex_);
    if (fired) is_armed_ = false;  // false if this is the first turn
    if (is_closed_) return false;
    if (holder_ == Holder::own || take_from_held(watch, now)) return true;
    if (holder_ != Holder::none) continue;
    const auto left = given_up_at_ + kGrace - now;
    if (is_due_at_once_ || left <= std::chrono::nanoseconds::zero()) {
      is_due_at_once_ = false;
      holder_ = Holder::own;
      return true;
    }
    arm(left);
  }
}

// Returns true if the timer has fired.
bool ServingTurn::sleep() const {
  pollfd timer{timer_.number(), POLLIN, 0};
  constexpr auto kMax = std::chrono::duration_cast<std::chrono::milliseconds>(kMaxServe);
  if (::poll(&timer, 1, static_cast<int>(kMax.count())) <= 0) return false;
  std::uint64_t expirations = 0;
  return ::read(timer_.number(), &expirations, sizeof expirations) == sizeof expirations;
}

bool ServingTurn::take_from_held(Watch& watch, Clock::time_point now) {
  auto progress = progress_.load();
  const bool works = progress % 2 != 0;
  if (holder_ != Holder::application || works || progress != watch.progress) {
    watch = {progress, now};
    return false;
  }
  if (now - watch.since < kHeld || !progress_.compare_exchange_strong(progress, progress + 2))
    return false;
  holder_ = Holder::own;
  leader_ = nullptr;
  ++displaced_;
  own_until_ = std::max(own_until_, now + kAfterHeld);
  return true;
}

// The system wakes one of the threads that wait for the sockets. If that is the thread that is held
// up, the participant's thread must check the sockets by itself.
std::chrono::nanoseconds ServingTurn::longest_own() const {
  return displaced_ > 0 ? kBesideHeld : kMaxOwn;
}

bool ServingTurn::yield() {
  std::shared_ptr<WaitSetState> set;
  {
    const auto now = Clock::now();
    const std::lock_guard held(mutex_);
    if (is_closed_) return true;
    if (count_ != 1 || !list_->may_serve_ || !returns_soon_ || now < own_until_) return false;
    set = list_->set_;
    holder_ = Holder::none;
    given_up_at_ = now;
    arm(kGrace);
  }
  if (set)
    set->notify();
  else
    server_.notify_waiting();
  return true;
}

void ServingTurn::prefer_own(std::chrono::nanoseconds how_long) {
  const auto until = Clock::now() + how_long;
  const std::lock_guard held(mutex_);
  own_until_ = std::max(own_until_, until);
}

bool ServingTurn::take_over() {
  const std::lock_guard held(mutex_);
  if (holder_ != Holder::none) return false;
  arm(std::chrono::nanoseconds::zero());
  return true;
}

void ServingTurn::close() {
  std::unique_lock held(mutex_);
  is_closed_ = true;
  arm(std::chrono::nanoseconds::zero());
  if (holder_ == Holder::application) server_.end_serving();
  given_up_.wait(held, [&] { return holder_ != Holder::application && displaced_ == 0; });
}

}  // namespace ddssec::rtps
