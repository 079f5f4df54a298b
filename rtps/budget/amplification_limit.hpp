// Limits the octets that are sent to participants that have not proven their addresses.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "rtps/budget/source_address.hpp"

namespace ddssec::rtps {

/// An attacker can announce a participant with the addresses of other hosts. As long as a
/// participant is limited, less than three times the octets that arrived in its name are sent to it
/// (RFC 9000, section 8.1), counted for each address. Addresses that it has proved are not limited.
/// The octets from one source pay only for the addresses that this source announced, and for its
/// own. So an attacker cannot use up what an honest peer earned, and gains nothing by announcing
/// the peer's address first. Participants that are not limited may be sent any amount.
class AmplificationLimit {
 public:
  static constexpr std::size_t kFactor = 3;
  /// The largest credit that one source may save for one participant, in octets to be sent.
  static constexpr std::size_t kMaxSaved = std::size_t{256} << 10;

  /// Sets the secret from which challenges are computed. An attacker must not know it. Without a
  /// secret no address can be proven.
  void set_secret(const Sha256Digest& secret) { secret_ = secret; }
  /// Notes that a datagram of this many octets is being received from `source`.
  void begin_datagram(const SourceAddress& source, std::size_t octets);
  /// Limits the participant from now on. `addresses` are its addresses, and `sources` the sources
  /// that announced each of them.
  void begin(const GuidPrefix& participant, std::span<const Locator> addresses,
             std::span<const SourceAddress> sources);
  /// Changes the participant's addresses. The saved credit is lost, except that of these sources
  /// and of the addresses themselves.
  void set_addresses(const GuidPrefix& participant, std::span<const Locator> addresses,
                     std::span<const SourceAddress> sources);
  /// Ends the limit, because the participant authenticated or was removed.
  void end(const GuidPrefix& participant) { accounts_.erase(participant); }
  bool is_limited(const GuidPrefix& participant) const {
    return !accounts_.empty() && accounts_.contains(participant);
  }
  /// Credits the datagram to this participant, in whose name it arrived. It counts once, for the
  /// first participant. Returns how many more octets may be sent.
  std::size_t add_credit(const GuidPrefix& participant);
  /// Returns the challenge in a message to that participant at that address, whatever its port.
  /// Only a receiver there can repeat it. Empty if there is no secret.
  Bytes challenge(const GuidPrefix& participant, const Locator& host) const;
  /// Checks a challenge that the participant repeated. If it is that of one of its addresses, the
  /// participant can be reached there, whatever the source of the datagram, which can be forged.
  /// Returns true if it is one.
  bool prove(const GuidPrefix& participant, BytesView repeated);
  /// True if the participant is limited and proved this very address, whatever its port. An IPv6
  /// address proves no other one, although both pay for what is sent to either.
  bool is_proven(const GuidPrefix& participant, const Locator& address);

  /// Returns the number of octets that may be sent to at least one of the addresses.
  std::size_t left(const GuidPrefix& participant, std::span<const Locator> to);
  /// Returns the addresses to which a message of this many octets may be sent, in the order of
  /// `to`, and charges them for it.
  LocatorList charge(const GuidPrefix& participant, std::size_t octets,
                     std::span<const Locator> to);

 private:
  struct Source {
    SourceAddress address;
    std::size_t saved = 0;
    bool is_proven = false;  ///< true if the participant can be reached there
  };
  struct Account {
    std::vector<std::pair<Locator, SourceAddress>> addresses = {};
    /// The sources that announced an address, and the addresses themselves.
    std::vector<Source> sources = {};
    LocatorList proven = {};  ///< the proven addresses, without ports
    std::size_t turn = 0;     ///< whose turn it is, of the addresses that other sources pay for

    Source* find(const SourceAddress& address);
    void add(const SourceAddress& address);
    /// True if the address is one of the participant's, or announced one.
    bool has_use_for(const SourceAddress& address) const;
    /// Returns the source that pays for the address: itself or the one that announced it. nullptr
    /// if none does.
    Source* payer(const Locator& to);
    bool is_proven(const Locator& to);
    std::size_t left(const Locator& to);
  };
  Account* find(const GuidPrefix& participant);

  std::map<GuidPrefix, Account> accounts_;
  std::optional<Sha256Digest> secret_;
  SourceAddress source_;          ///< source of the datagram that is being received
  std::size_t not_credited_ = 0;  ///< octets of that datagram, until a source has got them
};

}  // namespace ddssec::rtps
