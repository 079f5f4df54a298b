// One remote participant's way from its announcement to its authentication (DDS-Security 8.3.2,
// 9.3.4): what is sent, answered and sent again. No I/O, clock or lock: the caller brings messages
// and time and sends what comes out.
#pragma once

#include <memory>
#include <variant>

#include "plugins/spi/authentication.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "rtps/security/generic_message.hpp"
#include "rtps/security/work_budget.hpp"

namespace ddssec::rtps {

/// Hands out the numbers of our stateless messages.
class MessageNumbers {
 public:
  std::int64_t next() { return ++last_; }

 private:
  std::int64_t last_ = 0;
};

/// States: starting -> requesting (we have the lower GUID) or awaiting (the peer has) -> finished,
/// and failed from each of the first three. A message that is refused changes nothing.
class PeerHandshake {
 public:
  struct Sides {
    Guid own_guid, peer_guid;
    spi::IdentityHandle own;
    spi::Token peer_identity_token;
    /// Fast DDS knows no auth_request.
    bool send_auth_request = true;
  };
  /// `own_data`: c.pdata of ours, a big-endian parameter list.
  PeerHandshake(spi::Authentication& plugin, Sides sides, std::shared_ptr<const Bytes> own_data,
                MessageNumbers& numbers, MonotonicTime now);
  ~PeerHandshake();
  PeerHandshake(const PeerHandshake&) = delete;
  PeerHandshake& operator=(const PeerHandshake&) = delete;

  using Messages = std::vector<GenericMessage>;
  /// What is due goes to `out`.
  void tick(MonotonicTime now, Messages& out);
  /// A message of class dds.sec.auth that names us as its destination and the peer as its source.
  void receive(const GenericMessage& message, MonotonicTime now, Messages& out);
  MonotonicTime next_tick() const { return next_; }
  bool started() const { return !std::holds_alternative<Starting>(state_); }
  /// Starts at that time instead.
  void start_at(MonotonicTime time) { next_ = time; }
  /// How many messages of the peer the plugin did not take.
  std::uint64_t refusals() const { return refusals_; }

  bool finished() const { return std::holds_alternative<Finished>(state_); }
  /// Why it will never be, if so.
  const std::optional<Error>& failure() const { return failure_; }
  /// Valid when finished.
  spi::HandshakeHandle handle() const;
  /// The peer's, once it was validated; nil before.
  spi::IdentityHandle peer_identity() const { return peer_; }

  static constexpr MonotonicTime kDelay = std::chrono::milliseconds(10);
  static constexpr MonotonicTime kResend = std::chrono::seconds(1);
  static constexpr MonotonicTime kGiveUp = std::chrono::seconds(100);
  static constexpr std::size_t kMostAnswers = 4;
  /// Handshake messages of one peer that are looked at: so many at once, then so many a second.
  static constexpr int kBurst = 12;
  static constexpr MonotonicTime kRefill = std::chrono::milliseconds(250);

 private:
  struct Answer {
    spi::HandshakeHandle handle;
    GenericMessage reply;
  };
  struct Starting {};
  struct Requesting {
    spi::HandshakeHandle handle;
    GenericMessage request;
  };
  struct Awaiting {
    std::vector<Answer> answers;  ///< to different requests, of which one is honest
  };
  struct Finished {
    spi::HandshakeHandle handle;
    std::optional<GenericMessage> final;  ///< ours, if we began
  };

  void start(MonotonicTime now, Messages& out);
  void on_request(const GenericMessage& message, Messages& out);
  void on_reply(const GenericMessage& message, Messages& out);
  void on_final(const GenericMessage& message);
  void answer(spi::Authentication::HandshakeStep step, const MessageIdentity& to, Messages& out);
  GenericMessage message_of(std::string_view message_class, spi::Token token,
                            const MessageIdentity& related);
  void fail_with(Error error);

  spi::Authentication& plugin_;
  const Sides sides_;
  const std::shared_ptr<const Bytes> own_data_;
  MessageNumbers& numbers_;
  const MonotonicTime give_up_;
  MonotonicTime next_;
  spi::IdentityHandle peer_;
  std::optional<GenericMessage> auth_request_;
  std::variant<Starting, Requesting, Awaiting, Finished> state_;
  std::optional<Error> failure_;
  WorkBudget budget_;
  std::uint64_t refusals_ = 0;
};

}  // namespace ddssec::rtps
