// Sends and receives key tokens by the volatile secure endpoints (DDS-Security 8.8.7, 8.8.8), which
// exist once for each peer.
#pragma once

#include "rtps/security/security_core.hpp"

namespace ddssec::rtps {

class KeyExchange {
 public:
  /// Of one message with tokens: many times what keys take.
  static constexpr std::size_t kMaxTokenOctets = 4096;
  /// Of the messages of one peer that came before others of it.
  static constexpr StatefulReader::Limits kVolatileLimits{.largest_sample = 64 << 10,
                                                          .held_octets = std::size_t{1} << 20};

  /// What a peer did not acknowledge of our messages; further ones are made when it did.
  static constexpr std::size_t kMaxUnacknowledgedOctets = std::size_t{256} << 10;

  explicit KeyExchange(SecurityCore& core) : core_(core) {}

  /// Opens the channel to a peer that has just authenticated, and sends our participant key. Error:
  /// those of making its tokens.
  Status open(Peer& peer);
  /// The endpoints for a peer; nullptr before it authenticated.
  StatefulWriter* volatile_writer(const GuidPrefix& prefix);
  StatefulReader* volatile_reader(const GuidPrefix& prefix);
  /// It has all keys that it needs of us, and we of it.
  void join(Peer& peer);
  /// A message that only the peer itself can acknowledge.
  void probe(Peer& peer);
  /// A question that leaves nothing behind: a HEARTBEAT that every reader must answer.
  void ask_for_sign_of_life(Peer& peer);

  /// The peer acknowledged something: what waits for that goes out.
  void note_acknowledged(Peer& peer);
  /// What had no room among the early tokens is offered again.
  void tick();
  MonotonicTime next_tick() const { return have_room_.empty() ? kNever : core_.now; }

  /// Brings a local and a remote endpoint together; true: they can be matched now, else on_keys
  /// says when.
  bool introduce(const EntityId& local, const Guid& remote, bool relay_only);

  // Key revision.
  /// While it is under way, new peers and endpoints get the revised keys, too.
  void set_revising(bool revising);
  void send_revised(Peer& peer);
  /// It has our keys, and gets the next ones.
  static bool is_trusted(const Peer& peer);
  /// It has acknowledged all keys that were sent to it, or is not trusted.
  static bool is_up_to_date(const Peer& peer);

 private:
  void send(Peer& peer, GenericMessage message);
  void send_tokens(Peer& peer, std::string_view message_class, const Guid& from, const Guid& to,
                   std::vector<spi::Token> tokens);
  void send_endpoint_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                            std::vector<spi::Token> tokens);
  void add_waiting(Association& association, const EntityId& local, const Guid& remote,
                   spi::KeyStage stage);
  void send_waiting(Peer& peer);
  bool may_send(const Association& association) const;
  /// False: there is no room for it now, and it is to come again.
  bool on_message(const GuidPrefix& prefix, const Change& change);
  void on_participant_tokens(Peer& peer, const GenericMessage& message);
  bool on_endpoint_tokens(Peer& peer, GenericMessage message, std::size_t octets);
  /// True: the pair has become ready.
  bool apply_tokens(Peer& peer, const GenericMessage& message);

  SecurityCore& core_;
  std::int64_t last_number_ = 0;
  bool revising_ = false;
  std::vector<GuidPrefix> have_room_;  ///< peers of which early tokens were taken since tick()
};

}  // namespace ddssec::rtps
