// Pairs of endpoints whose key tokens, or requests for them, wait until the peer has acknowledged
// earlier ones.
#pragma once

#include <algorithm>
#include <map>
#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::rtps {

/// The pairs of one peer, each pair once and without its tokens. So a peer that acknowledges
/// nothing costs little memory for each pair, and none for pairs that no longer exist.
class WaitingTokens {
 public:
  struct WaitingPair {
    EntityId local;
    Guid remote;
    std::optional<spi::KeyStage> stage;  ///< empty: the remote endpoint's keys are requested
  };

  bool empty() const { return pairs_.empty(); }
  std::size_t size() const { return pairs_.size(); }
  /// `stage`: see WaitingPair.
  void add(const EntityId& local, const Guid& remote, std::optional<spi::KeyStage> stage) {
    auto& due = pairs_[{local, remote}];
    if (!stage)
      due.is_wanted = true;
    else
      (*stage == spi::KeyStage::revised ? due.revised : due.in_use) = true;
  }
  /// Returns the next message to send. Of one pair, the request comes first, and the tokens of a
  /// revision come last.
  std::optional<WaitingPair> take() {
    if (pairs_.empty()) return std::nullopt;
    const auto at = pairs_.begin();
    auto& due = at->second;
    WaitingPair out{at->first.first, at->first.second, std::nullopt};
    if (!std::exchange(due.is_wanted, false)) {
      const bool is_in_use = std::exchange(due.in_use, false);
      if (!is_in_use) due.revised = false;
      out.stage = is_in_use ? spi::KeyStage::in_use : spi::KeyStage::revised;
    }
    if (!due.in_use && !due.revised) pairs_.erase(at);
    return out;
  }
  /// Notes that the revision's keys are in use from now on.
  void end_revision() {
    for (auto& [pair, due] : pairs_)
      if (std::exchange(due.revised, false)) due.in_use = true;
  }
  /// Forgets pairs that are not kept. Checks all pairs only if there are twice as many as remained
  /// after the last check.
  template <class F>
  void forget_unless(F&& is_kept) {
    if (pairs_.size() < look_at_) return;
    std::erase_if(pairs_,
                  [&](const auto& pair) { return !is_kept(pair.first.first, pair.first.second); });
    look_at_ = std::max(kFirstLook, 2 * pairs_.size());
  }

 private:
  static constexpr std::size_t kFirstLook = 1024;
  struct PairNeed {
    bool is_wanted = false, in_use = false, revised = false;
  };
  std::map<std::pair<EntityId, Guid>, PairNeed> pairs_;
  std::size_t look_at_ = kFirstLook;
};

}  // namespace ddssec::rtps
