// Sends and receives key tokens through the volatile secure endpoints (DDS-Security 1.2,
// clauses 9.8.8 and 9.8.9). There is one pair of these endpoints for each peer.
#pragma once

#include <functional>
#include <map>

#include "rtps/security/generic_message.hpp"
#include "rtps/security/security_core.hpp"

namespace ddssec::rtps {

/// Delivers the key tokens of one local participant to its peers, and theirs to the keyring.
class CryptoTokenExchange {
 public:
  /// Size limit for one message with key tokens, several times what keys need.
  static constexpr std::size_t kMaxTokenOctets = 4096;
  /// Size limit for a token with renewed documents. Larger ones are not sent.
  static constexpr std::size_t kMaxDocumentOctets = 60 << 10;
  /// Limits for the messages of one peer that arrived out of order.
  static constexpr StatefulReader::Limits kVolatileLimits{.largest_sample = 64 << 10,
                                                          .held_octets = std::size_t{1} << 20};

  /// Limit for messages that a peer has not acknowledged. Further ones are created when it has.
  static constexpr std::size_t kMaxUnacknowledgedOctets = std::size_t{256} << 10;

  explicit CryptoTokenExchange(SecurityCore& core) : core_(core) {}

  /// Opens the channel to a peer that has just authenticated, and sends the local participant key.
  /// Errors: those of creating its tokens.
  Status open(Peer& peer);
  /// Returns the peer's writer, as volatile_reader() returns its reader; nullptr before the peer
  /// has authenticated. A dormant peer has only a writer: nothing that it sends is taken.
  StatefulWriter* volatile_writer(const GuidPrefix& prefix);
  void readdress(Peer& peer, const LocatorList& addresses);
  StatefulReader* volatile_reader(const GuidPrefix& prefix);
  /// Joins the peer: both sides have all keys that they need from each other.
  void join(Peer& peer);
  /// Sends a message that only the peer itself can acknowledge.
  void probe(Peer& peer);
  /// Sends a new message, whatever else the peer has not acknowledged.
  void ask(Peer& peer) { send_notice(peer, message_class::kAreYouThere); }
  /// Sends a query that leaves nothing stored: a HEARTBEAT that every reader must answer.
  void ask_for_sign_of_life(Peer& peer) {
    if (is_trusted(peer)) peer.state.association()->volatile_writer->request_acknowledgments(true);
  }

  /// True if the peer has acknowledged enough of what was sent before.
  bool has_room(const Peer& peer) const;
  /// Sends a message with one token.
  void send_token(Peer& peer, std::string_view message_class, spi::Token token);
  /// Sends a message without content.
  void send_notice(Peer& peer, std::string_view message_class);
  /// Receives the messages of these classes, which this class does not understand itself. Only the
  /// peer can have sent them.
  using Listener = std::function<void(Peer&, const GenericMessage&)>;
  void listen(std::initializer_list<std::string_view> message_classes, const Listener& listener) {
    for (const auto& message_class : message_classes) listeners_[message_class] = listener;
  }

  /// Sends messages that waited until the peer acknowledged something.
  void note_acknowledged(Peer& peer);
  /// Offers again the messages for which there was no room among the early tokens.
  void tick();
  MonotonicTime next_tick() const { return have_room_.empty() ? kNever : core_.now; }

  /// Registers a local and a remote endpoint as a pair. Returns true if they can be matched now.
  /// Otherwise on_keys is called when they can.
  bool register_pair(const EntityId& local, const Guid& remote, bool is_relay_only);

  /// Asks a ddssec peer for the tokens of a remote endpoint, which it has sent before.
  void request_tokens(const EntityId& local, const Guid& remote);

  /// Gives pairs with endpoints of the peer the second protection that they lack, and sends its
  /// keys and those of messages, as far as there is room. Returns true if none lacks it now.
  bool complete_pairs(Peer& peer);
  /// The peer has none of the keys of the protection that comes into force here, or is in force:
  /// they are sent again, as far as there is room. The rest follows with complete_pairs, or when
  /// the peer has acknowledged some.
  void send_again(Peer& peer);

  // Key revision:
  /// Notes whether a revision is under way. While one is, new peers and endpoints also get the
  /// revised keys.
  void set_revising(bool revising);
  /// The keys are sent as far as there is room, those of messages first.
  void send_revised(Peer& peer);
  /// True if the peer has the local keys and gets the next ones.
  static bool is_trusted(const Peer& peer);
  /// True if the peer has acknowledged all keys that were sent to it, or is not trusted.
  static bool is_up_to_date(const Peer& peer);

 private:
  void send(Peer& peer, GenericMessage message);
  void send_tokens(Peer& peer, std::string_view message_class, const Guid& from, const Guid& to,
                   std::vector<spi::Token> tokens);
  /// For `protection` see Keyring::set_endpoint_tokens.
  void send_endpoint_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                            std::vector<spi::Token> tokens, ProtectionId protection = 0);
  void complete(Peer& peer, const EntityId& local, const Guid& remote);
  /// Returns false if there was no room, or if there were no keys of messages.
  bool complete_message_keys(Peer& peer);
  /// Returns false if there are none.
  bool send_message_keys(Peer& peer, ProtectionId protection, spi::KeyStage stage);
  /// Sends the keys of messages of that stage, also those of the protection that comes into force.
  void send_participant_tokens(Peer& peer, spi::KeyStage stage);
  void add_waiting(Association& association, const EntityId& local, const Guid& remote,
                   std::optional<spi::KeyStage> stage);
  void send_waiting(Peer& peer);
  /// Sends the keys of the pair's second protection, if it is the one that is to come.
  void send_second_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                          spi::KeyStage stage);
  /// Returns false if there is no room for the message now and it must be delivered again.
  bool on_message(const GuidPrefix& prefix, const Change& change);
  void on_participant_tokens(Peer& peer, const GenericMessage& message);
  void on_tokens_wanted(Peer& peer, const GenericMessage& message);
  bool on_endpoint_tokens(Peer& peer, GenericMessage message, std::size_t octets);
  /// Applies the tokens of the pair that arrived before it was registered. Returns true if there
  /// were any. `is_ready` becomes true if the pair has become ready.
  bool apply_early_tokens(Peer& peer, const EntityId& local, const Guid& remote, bool& is_ready);
  /// Returns true if the pair has become ready.
  bool apply_tokens(Peer& peer, const GenericMessage& message);

  SecurityCore& core_;
  std::int64_t last_number_ = 0;
  bool is_revising_ = false;
  std::map<std::string_view, Listener> listeners_;  ///< by the class of the message
  /// Peers for whose messages there is room, because early tokens of theirs were taken since the
  /// last tick.
  std::vector<GuidPrefix> have_room_;
};

}  // namespace ddssec::rtps
