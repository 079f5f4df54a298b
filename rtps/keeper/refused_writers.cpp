#include "rtps/keeper/refused_writers.hpp"

#include <exception>

#include "base/background_thread.hpp"

namespace ddssec::rtps {

RefusedWriters::RefusedWriters(std::function<bool(const Guid&)> again,
                               std::chrono::milliseconds pause)
    : again_(std::move(again)),
      pause_(pause),
      thread_(start_background_thread<std::thread>([this] { run(); })) {}

RefusedWriters::~RefusedWriters() {
  {
    const std::lock_guard held(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

bool RefusedWriters::add(const Guid& writer, const GuidPrefix& identity) {
  {
    const std::lock_guard held(mutex_);
    if (writers_.contains(writer)) return false;
    const auto own = counts_.find(identity);
    if ((own == counts_.end() ? 0 : own->second) >= kMax - writers_.size()) return true;
    writers_.emplace(writer, identity);
    ++counts_[identity];
  }
  changed_.notify_all();
  return true;
}

std::size_t RefusedWriters::size() const {
  const std::lock_guard held(mutex_);
  return writers_.size();
}

std::vector<Guid> RefusedWriters::waiting() const {
  const std::lock_guard held(mutex_);
  std::vector<Guid> out;
  for (const auto& [writer, identity] : writers_) out.push_back(writer);
  return out;
}

void RefusedWriters::remove(const Guid& writer) {
  const std::lock_guard held(mutex_);
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  const auto own = counts_.find(at->second);
  if (--own->second == 0) counts_.erase(own);
  writers_.erase(at);
}

bool RefusedWriters::is_stopping() const {
  const std::lock_guard held(mutex_);
  return is_stopping_;
}

void RefusedWriters::run() {
  const auto pause = [this] {
    std::unique_lock held(mutex_);
    changed_.wait(held, [&] { return is_stopping_ || !writers_.empty(); });
    return !changed_.wait_for(held, pause_, [&] { return is_stopping_; });
  };
  while (pause()) {
    try {
      for (const auto& writer : waiting())
        if (!is_stopping() && again_(writer)) remove(writer);
    } catch (const std::exception&) {
      continue;  // memory may be short, for example; those that still wait are tried again
    }
  }
}

}  // namespace ddssec::rtps
