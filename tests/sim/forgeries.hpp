// What somebody without keys can make of octets it has heard, and of names it knows.
#pragma once

#include "plugins/cryptography/send_key.hpp"
#include "tests/sim/invariants.hpp"
#include "tests/sim/mangle.hpp"
#include "tests/sim/network.hpp"

namespace ddssec::rtps::sim {

/// Header of one datagram, and submessages of both in some order.
Bytes splice(BytesView one, BytesView other, Dice& dice);

/// Makes bursts of forgeries, each of one kind.
class Forger {
 public:
  struct Forgery {
    Bytes octets;
    Locator from;
  };
  Forger(const Ledger& ledger, const Invariants& invariants, std::span<const Datagram> recorded,
         Dice& dice);
  /// `nodes`: how many addresses there are.
  std::vector<Forgery> burst(std::size_t nodes);
  /// Submessages of another participant, for a message that somebody protects.
  Bytes in_the_name_of_another();
  /// A sample of its owner's, protected by what each receiver of `token` holds. Empty: it has no
  /// key.
  Bytes by_stolen_key(const spi::Token& token);

 private:
  using Make = Bytes (Forger::*)();
  struct Kind {
    Make make;
    std::size_t most;  ///< in one burst
  };
  static std::span<const Kind> kinds();

  Bytes stranger();            ///< an announcement in a new name, like that of a member
  Bytes false_address();       ///< a recorded announcement with other addresses
  Bytes false_announcement();  ///< a recorded announcement with other contents
  Bytes farewell();            ///< the end of a participant
  Bytes endpoint();            ///< a clear announcement of an endpoint
  Bytes endpoint_end();
  Bytes sample() { return sample_of(endpoint_guid(true)); }  ///< clear DATA of a user's writer
  Bytes sample_of(const Guid& writer);
  Bytes fragment();         ///< clear DATA_FRAG of it
  Bytes acknowledgement();  ///< clear ACKNACK or NACK_FRAG
  Bytes horizon();          ///< clear HEARTBEAT or GAP
  Bytes handshake();        ///< a recorded handshake message, changed
  Bytes question();         ///< an auth_request
  Bytes handshake_fragment();
  Bytes keys();  ///< a clear message of the key exchange
  Bytes liveliness();
  Bytes other_time();         ///< a recorded datagram behind INFO_TS
  Bytes other_destination();  ///< a recorded datagram behind INFO_DST
  Bytes garbage();

  /// A recorded datagram that was protected by that key; nullptr: none was heard.
  const Datagram* protected_by(const KeyId& sender);
  /// Where that sender may go on after a datagram of its own.
  cryptography::SendStart after(BytesView datagram, const KeyId& sender);
  /// Whose MACs a datagram bears.
  static std::vector<KeyId> receivers_of(BytesView datagram);
  GuidPrefix name();
  /// Of a user's endpoint that was there once, of that participant if it had one.
  Guid endpoint_guid(bool writes, const std::optional<GuidPrefix>& whose = {});
  /// The payload of a recorded submessage of that writer; empty: none was heard.
  Bytes heard(const EntityId& writer);
  Bytes changed_announcement(const std::function<void(ParticipantData&)>& change);
  Bytes behind(const std::function<void(SpanWriter&)>& what);

  const Ledger& ledger_;
  const Invariants& invariants_;
  std::span<const Datagram> recorded_;
  std::optional<ParticipantData> member_;  ///< what strangers look like
  Dice& dice_;
};

}  // namespace ddssec::rtps::sim
