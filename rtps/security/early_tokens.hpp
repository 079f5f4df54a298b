// Key tokens of a peer's endpoints that came before discovery said which endpoints these are.
#pragma once

#include <functional>
#include <vector>

#include "rtps/security/generic_message.hpp"

namespace ddssec::rtps {

/// Of one peer, bounded in number and octets; the oldest message gives way.
class EarlyTokens {
 public:
  static constexpr std::size_t kMaxMessages = 1024;
  static constexpr std::size_t kMaxOctets = std::size_t{512} << 10;
  /// Of one pair of endpoints: those in use and revised ones.
  static constexpr std::size_t kMaxOfPair = 2;

  /// `octets`: what the message took on the wire.
  void keep(GenericMessage message, std::size_t octets);
  /// Calls `use` with each message of that pair, oldest first, and drops it.
  void take(const Guid& local, const Guid& remote,
            const std::function<void(const GenericMessage&)>& use);

 private:
  struct Kept {
    GenericMessage message;
    std::size_t octets;
    bool is_of(const Guid& local, const Guid& remote) const {
      return message.destination_endpoint == local && message.source_endpoint == remote;
    }
  };
  void drop(std::vector<Kept>::iterator at);

  std::vector<Kept> kept_;
  std::size_t octets_ = 0;
};

}  // namespace ddssec::rtps
