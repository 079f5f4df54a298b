// How much may be sent to participants that have not proven their addresses.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "rtps/budget/source_address.hpp"

namespace ddssec::rtps {

/// A stranger can announce a participant, and name the addresses of others as its own. As long as a
/// participant is limited, less than three times the octets that came in its name are sent to it
/// (RFC 9000, section 8.1), each address counted. Only the addresses that it proved are free. What
/// came from one source pays for the addresses that this source announced, and for its own: so an
/// attacker cannot use up what an honest peer earned, and takes nothing from it by announcing its
/// address first. Participants that are not limited may be sent anything.
class AmplificationLimit {
 public:
  static constexpr std::size_t kFactor = 3;
  /// What one source may save up for one participant, in octets to be sent.
  static constexpr std::size_t kMaxSaved = std::size_t{256} << 10;

  /// What challenges are made of. An attacker must not know it. Without it no address is proven.
  void set_secret(const Sha256Digest& secret) { secret_ = secret; }
  /// A datagram of so many octets is being received from there.
  void begin_datagram(const SourceAddress& source, std::size_t octets);
  /// From now on that participant is limited. Its addresses, and the source that announced each.
  void limit(const GuidPrefix& participant, std::span<const Locator> addresses,
             std::span<const SourceAddress> sources);
  /// It has other addresses now. What was saved by other sources than these and the addresses' own
  /// is lost.
  void set_addresses(const GuidPrefix& participant, std::span<const Locator> addresses,
                     std::span<const SourceAddress> sources);
  /// It authenticated, or is forgotten.
  void lift(const GuidPrefix& participant) { accounts_.erase(participant); }
  bool is_limited(const GuidPrefix& participant) const {
    return !accounts_.empty() && accounts_.contains(participant);
  }
  /// The datagram came in the name of that participant, and counts once, for the first one. How
  /// many octets more may be sent for it.
  std::size_t credit(const GuidPrefix& participant);
  /// What a message to that participant at that host contains, so that only a receiver there can
  /// repeat it. Empty: there is no secret.
  Bytes challenge(const GuidPrefix& participant, const SourceAddress& host) const;
  /// The participant repeated this. If it is the challenge of one of its hosts, it can be reached
  /// there, wherever it says so from: the source of a datagram can be forged. True: it is one.
  bool prove(const GuidPrefix& participant, BytesView repeated);

  /// How many octets may be sent to at least one of the addresses.
  std::size_t left(const GuidPrefix& participant, std::span<const Locator> to);
  /// The addresses that a message of so many octets may be sent to, in the order of `to`. They are
  /// charged for it.
  LocatorList take(const GuidPrefix& participant, std::size_t octets, std::span<const Locator> to);

 private:
  struct Source {
    SourceAddress address;
    std::size_t saved = 0;
    bool is_proven = false;  ///< the participant can be reached there
  };
  struct Account {
    std::vector<std::pair<Locator, SourceAddress>> addresses = {};
    /// Who announced an address, and the addresses themselves.
    std::vector<Source> sources = {};
    std::size_t turn = 0;  ///< of the addresses that other sources pay for

    Source* find(const SourceAddress& address);
    void add(const SourceAddress& address);
    /// It announced an address, or is one.
    bool has_use_for(const SourceAddress& address) const;
    /// The source that pays for it: itself or the one that announced it; nullptr: none does.
    Source* payer(const Locator& to);
    bool is_proven(const Locator& to);
    std::size_t left(const Locator& to);
  };
  Account* find(const GuidPrefix& participant);

  std::map<GuidPrefix, Account> accounts_;
  std::optional<Sha256Digest> secret_;
  SourceAddress source_;          ///< of the datagram that is being received
  std::size_t not_credited_ = 0;  ///< its octets, as long as no source got them
};

}  // namespace ddssec::rtps
