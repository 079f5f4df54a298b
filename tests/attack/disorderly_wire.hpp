// A wire between nodes that delivers messages in any order.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace ddssec::attack {

/// Holds the messages that are on their way between nodes. What a network does to a message before,
/// such as losing it, is decided by the test, with roll().
template <class Node, class Message>
class DisorderlyWire {
 public:
  explicit DisorderlyWire(std::uint32_t seed) : dice_(seed) {}

  /// Returns a number below `sides`.
  std::uint32_t roll(std::uint32_t sides) { return static_cast<std::uint32_t>(dice_() % sides); }
  void put(Node& from, Node& to, Message message) {
    messages_.push_back({&from, &to, std::move(message)});
  }
  /// Calls `deliver` with sender, receiver and message for three quarters of what is on the wire,
  /// in any order. `deliver` may put answers on it, and these may be delivered, too.
  template <class F>
  void deliver_most(F&& deliver) {
    for (auto left = messages_.size() * 3 / 4; left > 0 && !messages_.empty(); --left) {
      std::swap(messages_[roll(static_cast<std::uint32_t>(messages_.size()))], messages_.back());
      auto one = std::move(messages_.back());
      messages_.pop_back();
      deliver(*one.from, *one.to, one.message);
    }
  }
  void clear() { messages_.clear(); }

 private:
  struct OnItsWay {
    Node* from;
    Node* to;
    Message message;
  };

  std::mt19937 dice_;
  std::vector<OnItsWay> messages_;
};

}  // namespace ddssec::attack
