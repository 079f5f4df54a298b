// The handshake messages with one remote participant, from its announcement to its authentication
// (DDS-Security 1.2, clauses 9.3.2 and 10.3.4): what is sent, answered and repeated. No I/O, clock
// or lock: the caller passes in messages and times, and sends the resulting messages.
#pragma once

#include <memory>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/spi/authentication.hpp"
#include "rtps/security/handshake_answers.hpp"

namespace ddssec::rtps {

/// The values that the handshakes of a participant with all its peers share.
struct HandshakeAccount {
  std::int64_t last_number = 0;   ///< of the local stateless messages
  std::size_t answer_octets = 0;  ///< see HandshakeAnswers
};

/// The plugin's handle for a peer. It is returned when nothing refers to it any more: neither a
/// handshake nor a peer that left while it was trusted.
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

/// The work that a message requires before it can be distinguished from a forged one.
enum class Effort : std::uint8_t {
  none,     ///< none: the message does not fit the current state
  memory,   ///< repeating an earlier answer
  request,  ///< public-key work for any sender that can create a request
  echo,     ///< public-key work for a sender that received the last local message
};

/// The handshakes with one peer. A refused message changes nothing. Requests of either side are
/// processed next to a finished handshake: a side that lost its state may authenticate again, and
/// only a new proof replaces the old one.
class PeerHandshake {
 public:
  struct Sides {
    Guid own_guid, peer_guid;
    spi::IdentityHandle own;
    spi::Token peer_identity_token;
    /// false for Fast DDS, which does not know auth_request.
    bool send_auth_request = true;
    /// True if the peer claims to run ddssec: it repeats the challenge in the local auth_request.
    bool repeats_challenges = false;
    /// Set if the peer left and is still known: the plugin has one handle for all its handshakes.
    std::shared_ptr<const PeerIdentity> known_identity = {};
  };
  /// `own_data` is the local c.pdata, a big-endian parameter list.
  PeerHandshake(spi::Authentication& plugin, Sides sides, std::shared_ptr<const Bytes> own_data,
                HandshakeAccount& account, MonotonicTime now);
  PeerHandshake(const PeerHandshake&) = delete;
  PeerHandshake& operator=(const PeerHandshake&) = delete;

  using Messages = std::vector<GenericMessage>;
  /// Appends the messages that are due to `out`.
  void tick(MonotonicTime now, Messages& out);
  /// The facts about a message that are known before any work is done for it.
  struct Assessment {
    Effort effort = Effort::none;
    Sha256Digest digest = {};  ///< digest of the peer's request or reply, unless the effort is none
  };
  /// Checks a message of class dds.sec.auth that names the local participant as destination and the
  /// peer as source. Does no public-key work.
  Assessment assess(const GenericMessage& message) const;
  /// Processes such a message; the caller has allowed its effort. Returns false if there was no
  /// room for it.
  bool receive(const GenericMessage& message, const Assessment& assessment, MonotonicTime now,
               Messages& out);
  /// Processes an auth_request of the peer. Returns the challenge that it repeats, or empty.
  Bytes receive_auth_request(const GenericMessage& message, Messages& out);
  /// Notes that the peer's later announcement claims that it runs ddssec: the first announcement
  /// may be forged.
  void note_repeats_challenges() { repeats_challenges_ = true; }
  bool repeats_challenges() const { return sides_.repeats_challenges || repeats_challenges_; }
  /// Returns the local auth_request, without a challenge; empty if there is none to send.
  std::optional<GenericMessage> auth_request() const;
  MonotonicTime next_tick() const { return next_; }
  bool is_started() const { return is_started_; }
  /// Returns how often its messages were sent, not counting answers.
  int repetitions() const { return repetitions_; }
  /// Returns the time of the start; empty before it.
  std::optional<MonotonicTime> started_at() const {
    return is_started_ ? std::optional(began_) : std::nullopt;
  }
  /// Sets the time of the start or of the next repetition.
  void start_at(MonotonicTime time) { next_ = time; }
  /// Repeats messages that wait for an answer not later than this, however rare repetitions have
  /// become, because the peer was announced with another address.
  void repeat_by(MonotonicTime time);
  /// Notes that the peer sent something, so that repetitions need not become rare.
  void note_heard() { was_heard_ = true; }
  /// Notes a sign that messages of the peer arrive, which anyone can send. Messages that wait for
  /// an answer are repeated not later than kSignPause after the last time.
  void note_sign(MonotonicTime now);
  /// Repeats messages that wait for an answer at once, if there was time for an answer, because a
  /// message of the peer had to be dropped.
  void shorten_delays(MonotonicTime now);
  /// Begins a new handshake next to the finished one, if the local side is the one that begins.
  void begin_again(MonotonicTime now);
  /// True if the local GUID is the lower one (DDS-Security 1.2, clause 10.3.3).
  bool is_initiator() const { return sides_.own_guid < sides_.peer_guid; }
  /// Returns the number of the peer's messages that the plugin refused.
  std::uint64_t refusals() const { return refusals_; }

  bool is_finished() const { return finished_.has_value(); }
  /// Returns true if a handshake was finished since the last call.
  bool take_proof() { return std::exchange(has_new_proof_, false); }
  /// Returns the reason why the handshake can never succeed, if there is one. No message of a third
  /// party, and no missing message, can cause it.
  const std::optional<Error>& failure() const { return failure_; }
  /// True if the handshake took too long. It continues at a slow pace as long as the peer is
  /// announced.
  bool is_overdue() const { return is_overdue_; }
  /// Returns the handle, which is valid when finished.
  spi::HandshakeHandle handle() const;
  /// Returns the peer's identity once it was validated; nullptr before.
  const std::shared_ptr<const PeerIdentity>& identity() const { return identity_; }
  HandshakeAnswers& answers() { return answers_; }
  /// Returns the peer's c.pdata, proven when finished; empty before.
  BytesView peer_data() const { return peer_data_; }

  static constexpr MonotonicTime kDelay = std::chrono::milliseconds(10);
  static constexpr MonotonicTime kFirstResend = std::chrono::milliseconds(300);
  static constexpr MonotonicTime kResend = std::chrono::seconds(1);
  static constexpr MonotonicTime kSlow = std::chrono::seconds(32);
  static constexpr MonotonicTime kSignPause = std::chrono::seconds(8);
  /// The handshake is overdue after this time, and the local request is created again; then again
  /// after the same time.
  static constexpr MonotonicTime kOverdue = std::chrono::seconds(100);
  /// How long a new request next to a finished handshake is repeated.
  static constexpr MonotonicTime kSecondTry = std::chrono::seconds(5);
  /// Properties of ddssec in an AuthRequestMessageToken: the challenge that the receiver must
  /// repeat (AmplificationLimit::challenge), and the last challenge that arrived from the receiver.
  static constexpr std::string_view kChallenge = "org.ddssec.challenge";
  static constexpr std::string_view kHeardChallenge = "org.ddssec.heard_challenge";

 private:
  struct Request {
    spi::HandshakeHandle handle;
    GenericMessage message;
    MonotonicTime until;  ///< end of repetitions; kNever for the first request
  };
  struct FinishedHandshake {
    spi::HandshakeHandle handle;
    Sha256Digest last;  ///< digest of the peer's message that is still answered, or of its request
    std::optional<GenericMessage> final;  ///< the local one, if the local side began
  };

  void start(MonotonicTime now, Messages& out);
  void become_overdue(MonotonicTime now);
  bool make_request(MonotonicTime until);
  Assessment assess_reply(const spi::Token& token,
                          const spi::Authentication::Outline& outline) const;
  Assessment assess_request(const spi::Token& token) const;
  void repeat_known(const GenericMessage& message, const Sha256Digest& digest, Messages& out);
  bool on_request(const GenericMessage& message, const Sha256Digest& digest, MonotonicTime now,
                  Messages& out);
  void on_reply(const GenericMessage& message, const Sha256Digest& digest, Messages& out);
  void on_final(const GenericMessage& message);
  void finish(FinishedHandshake finished, Bytes peer_data);
  MonotonicTime pause();
  GenericMessage message_of(std::string_view message_class, spi::Token token,
                            const MessageIdentity& related);

  spi::Authentication& plugin_;
  const Sides sides_;
  const std::shared_ptr<const Bytes> own_data_;
  HandshakeAccount& account_;
  MonotonicTime overdue_at_;
  MonotonicTime next_;
  MonotonicTime began_{};
  MonotonicTime last_sent_{};      ///< or tried
  MonotonicTime refused_until_{};  ///< the plugin had no room for the peer
  std::shared_ptr<const PeerIdentity> identity_;
  std::optional<GenericMessage> auth_request_;
  Bytes heard_challenge_;  ///< from the peer's auth_request
  bool repeats_challenges_ = false;
  bool is_started_ = false;
  bool was_heard_ = false;
  bool has_shorter_delays_ = false;
  bool is_overdue_ = false;
  int repetitions_ = 0;
  std::optional<Request> request_;
  HandshakeAnswers answers_;
  std::optional<FinishedHandshake> finished_;
  bool has_new_proof_ = false;
  Bytes peer_data_;
  std::optional<Error> failure_;
  std::uint64_t refusals_ = 0;
};

}  // namespace ddssec::rtps
