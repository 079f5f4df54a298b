// One remote participant's way from its announcement to its authentication (DDS-Security 8.3.2,
// 9.3.4): what is sent, answered and sent again. No I/O, clock or lock: the caller brings messages
// and time and sends what comes out.
#pragma once

#include <memory>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/spi/authentication.hpp"
#include "rtps/security/handshake_answers.hpp"

namespace ddssec::rtps {

/// What the handshakes of a participant with all of its peers share.
struct HandshakeAccount {
  std::int64_t last_number = 0;   ///< of our stateless messages
  std::size_t answer_octets = 0;  ///< see HandshakeAnswers
};

/// What the plugin knows of a peer. Returned when nothing refers to it any more: a handshake, or a
/// peer that left in good standing.
class PeerIdentity {
 public:
  PeerIdentity(spi::Authentication& plugin, spi::IdentityHandle handle)
      : plugin_(plugin), handle_(handle) {}
  ~PeerIdentity() { static_cast<void>(plugin_.return_identity_handle(handle_)); }
  PeerIdentity(const PeerIdentity&) = delete;
  PeerIdentity& operator=(const PeerIdentity&) = delete;
  spi::IdentityHandle handle() const { return handle_; }

 private:
  spi::Authentication& plugin_;
  const spi::IdentityHandle handle_;
};

/// What a message asks for before it can be told from a forged one.
enum class Effort : std::uint8_t {
  none,     ///< it fits nothing that we wait for
  memory,   ///< what we answered before is sent again
  request,  ///< public-key work for any sender that knows how to ask
  echo,     ///< public-key work for a sender that received our last message
};

/// A message that is refused changes nothing. Requests, ours or the peer's, stand beside a
/// handshake that is finished: a side that lost the other may authenticate again, and only a new
/// proof replaces the old one.
class PeerHandshake {
 public:
  struct Sides {
    Guid own_guid, peer_guid;
    spi::IdentityHandle own;
    spi::Token peer_identity_token;
    /// Fast DDS knows no auth_request.
    bool send_auth_request = true;
    /// The peer says that it is one of ours: it repeats the challenge in our auth_request.
    bool repeats_challenges = false;
    /// The peer left and is still known: the plugin has one handle for all of its handshakes.
    std::shared_ptr<const PeerIdentity> known_identity = {};
  };
  /// `own_data`: c.pdata of ours, a big-endian parameter list.
  PeerHandshake(spi::Authentication& plugin, Sides sides, std::shared_ptr<const Bytes> own_data,
                HandshakeAccount& account, MonotonicTime now);
  PeerHandshake(const PeerHandshake&) = delete;
  PeerHandshake& operator=(const PeerHandshake&) = delete;

  using Messages = std::vector<GenericMessage>;
  /// What is due goes to `out`.
  void tick(MonotonicTime now, Messages& out);
  /// What is known of a message before anything is spent on it.
  struct Weighed {
    Effort effort = Effort::none;
    Sha256Digest digest = {};  ///< of a peer's request or reply that is worth something
  };
  /// A message of class dds.sec.auth that names us as its destination and the peer as its source.
  /// No public-key work.
  Weighed weigh(const GenericMessage& message) const;
  /// Such a message, once its effort may be spent. False: there was no room for it.
  bool receive(const GenericMessage& message, const Weighed& weighed, MonotonicTime now,
               Messages& out);
  /// An auth_request of the peer: the challenge that it repeats, or nothing.
  Bytes receive_auth_request(const GenericMessage& message, Messages& out);
  /// The same, if it announced itself as one of ours later: the first announcement may be forged.
  void note_repeats_challenges() { repeats_challenges_ = true; }
  bool repeats_challenges() const { return sides_.repeats_challenges || repeats_challenges_; }
  /// Ours, without a challenge; nothing if there is none to send.
  std::optional<GenericMessage> auth_request() const;
  MonotonicTime next_tick() const { return next_; }
  bool started() const { return started_; }
  /// How often its messages were sent, but for answers.
  int repetitions() const { return repetitions_; }
  /// When it did; nothing before.
  std::optional<MonotonicTime> began() const {
    return started_ ? std::optional(began_) : std::nullopt;
  }
  /// Starts at that time instead.
  void start_at(MonotonicTime time) { next_ = time; }
  /// The peer said something: it is worth more than a few repetitions.
  void note_heard() { heard_ = true; }
  /// Something of the peer had to be dropped: what waits for an answer is sent again at once,
  /// if there was time for an answer.
  void hasten(MonotonicTime now);
  /// A new handshake beside the finished one, if we are the side that begins.
  void begin_again(MonotonicTime now);
  /// We have the lower GUID (DDS-Security 10.3.3).
  bool begins() const { return sides_.own_guid < sides_.peer_guid; }
  /// How many messages of the peer the plugin did not take.
  std::uint64_t refusals() const { return refusals_; }

  bool finished() const { return finished_.has_value(); }
  /// A handshake was finished since this was last asked.
  bool take_proof() { return std::exchange(has_new_proof_, false); }
  /// Why it will never be, if so: nothing that a stranger sends or holds back.
  const std::optional<Error>& failure() const { return failure_; }
  /// It took too long. It goes on, at a slow pace, for as long as the peer is announced.
  bool is_overdue() const { return overdue_; }
  /// Valid when finished.
  spi::HandshakeHandle handle() const;
  /// The peer's, once it was validated; nullptr before.
  const std::shared_ptr<const PeerIdentity>& identity() const { return identity_; }
  HandshakeAnswers& answers() { return answers_; }
  /// The peer's c.pdata, proven when finished; empty before.
  BytesView peer_data() const { return peer_data_; }

  static constexpr MonotonicTime kDelay = std::chrono::milliseconds(10);
  static constexpr MonotonicTime kFirstResend = std::chrono::milliseconds(300);
  static constexpr MonotonicTime kResend = std::chrono::seconds(1);
  static constexpr MonotonicTime kSlow = std::chrono::seconds(32);
  /// After so long it is overdue, and our request is made anew; then again after as long.
  static constexpr MonotonicTime kOverdue = std::chrono::seconds(100);
  /// How long a new request beside a finished handshake is repeated.
  static constexpr MonotonicTime kSecondTry = std::chrono::seconds(5);
  /// Properties of our own in an AuthRequestMessageToken: what the receiver is to repeat
  /// (AmplificationLimit::challenge), and the last one that was heard from the receiver.
  static constexpr std::string_view kChallenge = "org.ddssec.challenge";
  static constexpr std::string_view kHeardChallenge = "org.ddssec.heard_challenge";

 private:
  struct Request {
    spi::HandshakeHandle handle;
    GenericMessage message;
    MonotonicTime until;  ///< not repeated any more; kNever for the first
  };
  struct Finished {
    spi::HandshakeHandle handle;
    Sha256Digest last;                    ///< the peer's message that we answer again, or request
    std::optional<GenericMessage> final;  ///< ours, if we began
  };

  void start(MonotonicTime now, Messages& out);
  void become_overdue(MonotonicTime now);
  bool make_request(MonotonicTime until);
  Weighed weigh_reply(const spi::Token& token) const;
  Weighed weigh_request(const spi::Token& token) const;
  void repeat_known(const GenericMessage& message, const Sha256Digest& digest, Messages& out);
  bool on_request(const GenericMessage& message, const Sha256Digest& digest, MonotonicTime now,
                  Messages& out);
  void on_reply(const GenericMessage& message, const Sha256Digest& digest, Messages& out);
  void on_final(const GenericMessage& message);
  void finish(Finished finished, Bytes peer_data);
  MonotonicTime pause();
  GenericMessage message_of(std::string_view message_class, spi::Token token,
                            const MessageIdentity& related);
  void fail_with(Error error);

  spi::Authentication& plugin_;
  const Sides sides_;
  const std::shared_ptr<const Bytes> own_data_;
  HandshakeAccount& account_;
  MonotonicTime overdue_at_;
  MonotonicTime next_;
  MonotonicTime began_{};
  MonotonicTime refused_until_{};  ///< the plugin had no room for the peer
  std::shared_ptr<const PeerIdentity> identity_;
  std::optional<GenericMessage> auth_request_;
  Bytes heard_challenge_;  ///< of the peer's auth_request
  bool repeats_challenges_ = false;
  bool started_ = false;
  bool heard_ = false;
  bool hastened_ = false;
  bool overdue_ = false;
  int repetitions_ = 0;
  std::optional<Request> request_;
  HandshakeAnswers answers_;
  std::optional<Finished> finished_;
  bool has_new_proof_ = false;
  Bytes peer_data_;
  std::optional<Error> failure_;
  std::uint64_t refusals_ = 0;
};

}  // namespace ddssec::rtps
