// Key tokens for a peer's endpoints that arrived before discovery announced these endpoints.
#pragma once

#include <functional>
#include <vector>

#include "base/clock.hpp"
#include "rtps/security/generic_message.hpp"

namespace ddssec::rtps {

/// The tokens of one peer, limited in number and octets. A message for which there is no room is
/// refused: its channel is reliable and delivers it again. The oldest message is dropped once it
/// has waited so long that discovery will hardly ever need it.
class EarlyTokens {
 public:
  static constexpr std::size_t kMaxMessages = 1024;
  static constexpr std::size_t kMaxOctets = std::size_t{512} << 10;
  /// Limit for one pair of endpoints: the tokens in use and revised ones, of two protections while
  /// the governance changes.
  static constexpr std::size_t kMaxOfPair = 4;
  static constexpr MonotonicTime kMinKept = std::chrono::seconds(30);

  /// Keeps a message; `octets` is its size as received. Returns false if there is no room now.
  bool keep(GenericMessage message, std::size_t octets, MonotonicTime now);
  /// Calls `use` with each message of that pair, oldest first, and removes it if `use` returns
  /// true. Returns true if any was removed. `use` may consume or keep further messages.
  bool consume(const Guid& local, const Guid& remote,
               const std::function<bool(const GenericMessage&)>& use);
  std::size_t size() const { return kept_.size(); }

 private:
  struct KeptMessage {
    GenericMessage message;
    std::size_t octets;
    MonotonicTime since;
    bool is_of(const Guid& local, const Guid& remote) const {
      return message.destination_endpoint == local && message.source_endpoint == remote;
    }
  };
  void drop(std::vector<KeptMessage>::iterator at);
  std::vector<KeptMessage> remove_all_of(const Guid& local, const Guid& remote);
  bool has_room(std::size_t octets) const {
    return kept_.size() < kMaxMessages && octets_ + octets <= kMaxOctets;
  }

  std::vector<KeptMessage> kept_;
  std::size_t octets_ = 0;
};

}  // namespace ddssec::rtps
