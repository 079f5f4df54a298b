// Forgeries that an attacker without keys can make of octets that it has heard, and of names that
// it knows.
#pragma once

#include "tests/sim/invariants.hpp"
#include "tests/sim/mangle.hpp"
#include "tests/sim/network.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps::sim {

/// Returns the submessages of a datagram, as far as it can be read. `datagram` owns them.
std::vector<BytesView> submessages_of(BytesView datagram);
/// Returns the header of one datagram, and submessages of both in some order.
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
  /// Returns one burst. `nodes` is the number of addresses.
  std::vector<Forgery> burst(std::size_t nodes);
  /// Returns submessages of another participant, for a message that an attacker protects.
  Bytes in_the_name_of_another();
  /// Returns announcements of kinds that were added later, so that `burst` draws what it did
  /// before: with loopback addresses, or with a parameter that comes twice.
  std::vector<Forgery> announcements(std::size_t nodes);
  /// Returns announcements of participants that have the longest lease, all from one machine.
  std::vector<Forgery> crowd();
  /// Returns clear DATA of a user's writer of that participant.
  Bytes sample_by(const GuidPrefix& writer);
  /// Returns the GUID of a user's endpoint that existed once, of that participant if it had one.
  Guid endpoint_guid(bool writes, const std::optional<GuidPrefix>& whose = {});

 private:
  using Make = Bytes (Forger::*)();
  struct Kind {
    Make make;
    std::size_t most;  ///< the largest number in one burst
  };
  static std::span<const Kind> kinds();
  std::vector<Forgery> burst_of(const Kind& kind, std::size_t nodes);

  ParticipantData member_in_a_new_name();
  Bytes stranger();              ///< an announcement in a new name, like that of a member
  Bytes false_address();         ///< a recorded announcement with other addresses
  Bytes false_announcement();    ///< a recorded announcement with other contents
  Bytes dispose_announcement();  ///< the end of a participant
  Bytes endpoint();              ///< a clear announcement of an endpoint
  Bytes endpoint_end();
  Bytes sample() { return sample_of(endpoint_guid(true)); }  ///< clear DATA of a user's writer
  Bytes sample_of(const Guid& writer);
  Bytes fragment();         ///< a clear DATA_FRAG of it
  Bytes acknowledgement();  ///< clear ACKNACK or NACK_FRAG
  Bytes horizon();          ///< clear HEARTBEAT or GAP
  Bytes handshake();        ///< a recorded handshake message, changed
  Bytes question();         ///< an auth_request
  Bytes handshake_fragment();
  Bytes keys();  ///< a clear message of the key exchange
  Bytes liveliness();
  Bytes other_time();         ///< a recorded datagram after INFO_TS
  Bytes other_destination();  ///< a recorded datagram after INFO_DST
  Bytes garbage();
  Bytes local_address();       ///< an announcement of addresses of the machine that hears it
  Bytes repeated_parameter();  ///< a recorded announcement with a parameter that comes twice

  GuidPrefix name();
  /// Returns the payload of a recorded submessage of that writer; empty if none was heard.
  Bytes heard(const EntityId& writer);
  Bytes changed_announcement(const std::function<void(ParticipantData&)>& change);
  Bytes behind(const std::function<void(SpanWriter&)>& what);

  const Ledger& ledger_;
  const Invariants& invariants_;
  std::span<const Datagram> recorded_;
  std::optional<ParticipantData> member_;  ///< the data that strangers imitate
  Dice& dice_;
};

}  // namespace ddssec::rtps::sim
