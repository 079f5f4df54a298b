// The properties that must always hold. The first violation ends a run.
#pragma once

#include <set>

#include "tests/sim/ledger.hpp"
#include "tests/sim/meter.hpp"

namespace ddssec::rtps::sim {

struct Violation {
  std::string_view invariant;
  std::string detail;
};

/// One endpoint of the simulation, honest or not.
struct End {
  const Subject* subject = nullptr;
  std::string_view topic;
  bool writes = false;
  Guid guid = {};
  MonotonicTime since{};  ///< its beginning
  bool durable = false;   ///< TRANSIENT_LOCAL; a reader then matches only such writers
  bool is_reliable = true;
};

// The names of the invariants, which failures print.
namespace invariant {
inline constexpr std::string_view kPermission = "nobody reads or writes without permission";
inline constexpr std::string_view kForged = "nothing forged is delivered or believed";
inline constexpr std::string_view kFresh = "a reader gets nothing that was written before it began";
inline constexpr std::string_view kOnce = "nothing is delivered twice or out of order";
inline constexpr std::string_view kHidden = "nothing protected is readable on the network";
inline constexpr std::string_view kAstray = "samples are sent only where their readers are";
inline constexpr std::string_view kLife = "a dead writer gives no sign of life";
inline constexpr std::string_view kMemory = "memory stays within its bound";
inline constexpr std::string_view kShare = "one certificate takes at most half of the places";
inline constexpr std::string_view kWork = "work stays within its bound";
inline constexpr std::string_view kReflection = "little is sent to addresses that never answered";
inline constexpr std::string_view kReunion = "honest pairs match once the network is fair";
inline constexpr std::string_view kNewcomer = "honest pairs match while attackers only add";
inline constexpr std::string_view kKept = "honest pairs stay matched while nothing is kept back";
inline constexpr std::string_view kGone = "a dead participant is forgotten";
inline constexpr std::string_view kLoss = "a matched reliable reader gets every sample";
}  // namespace invariant

class Invariants {
 public:
  /// Limit for the memory of one participant, whatever others do: the sum of the product's own
  /// bounds on what this cast can reach, and some room.
  static constexpr std::int64_t kMaxOctets = std::int64_t{24} << 20;
  /// The same limit for each further sibling.
  static constexpr std::int64_t kMaxOctetsOfSibling = std::int64_t{128} << 10;
  /// Limits for the branches of one call: a fixed number, and a number for each octet of a
  /// datagram. The most are taken by a tick after a process slept while strangers had filled the
  /// 512 places for participants, 675'035 in seed 29396245: 290'000 to write 130 handshake messages
  /// octet by octet, 180'000 for the handshakes of 330 strangers, 80'000 to remove 64 whose leases
  /// have ended (RemoteParticipants::kMaxEndsAtOnce), and some 250 for each other stranger. This is
  /// a third more. Without the limit of 64, the seed takes 934'458.
  static constexpr std::uint64_t kMaxBranches = 900'000;
  static constexpr std::uint64_t kMaxBranchesPerOctet = 400;
  /// Limit for the handshakes that one call begins: each costs public-key work.
  static constexpr std::size_t kMaxHandshakes = 100;
  /// How long messages of a writer may still be under way after its end.
  static constexpr MonotonicTime kMaxAfterlife = seconds(20);
  /// The same time if everything that was sent did arrive.
  static constexpr MonotonicTime kMaxLastWords = seconds(1);
  /// Limit for the moments at which one dead writer is heard after that: messages that were lost on
  /// the way to one reader and heard by another are new when an attacker brings them.
  static constexpr std::size_t kMaxLateSigns = 40;
  /// How long honest pairs may take to match, from the moment that the network is fair.
  static constexpr MonotonicTime kMaxReunion = seconds(150);
  /// The same time while strangers fill the tables and nothing else is attacked.
  static constexpr MonotonicTime kMaxInCrowd = seconds(10);
  static constexpr MonotonicTime kMaxExchange = seconds(20);
  /// How long a dead participant may be remembered after the network was fair: its lease, and what
  /// an attacker kept back of it, which is new.
  static constexpr MonotonicTime kMaxMemory = seconds(60);
  /// Limit for the octets to addresses where no participant is, beyond three for each octet that
  /// arrives.
  static constexpr std::size_t kMaxReflected = std::size_t{256} << 10;

  Invariants(const Ledger& ledger, const Protection& protection, const MonotonicTime& now)
      : ledger_(ledger), protection_(protection), now_(now) {}

  void expect_siblings(std::size_t count) {
    max_octets_ += static_cast<std::int64_t>(count) * kMaxOctetsOfSibling;
  }
  void on_started(const End& end) { ends_.insert_or_assign(end.guid, end); }
  void on_sent(const Subject& from, BytesView datagram);
  void on_matched(const End& local, const Guid& remote);
  void on_unmatched(const End& local, const Guid& remote);
  void on_delivered(const End& reader, const Change& change);
  void on_alive(const End& reader, const Guid& writer);
  void on_call(const Subject& whose, const Cost& before, const Cost& after, std::size_t octets);
  void on_handshakes(const Subject& whose, std::size_t begun);

  /// Begins or ends a time in which everything that honest participants send arrives, none of them
  /// ends, and neither do their endpoints.
  void set_besieged(bool besieged) {
    if (besieged) besieged_since_ = now_;
    besieged_ = besieged;
  }

  void fail(std::string_view invariant, std::string detail) {
    if (!violation_) violation_ = {invariant, std::move(detail)};
  }
  /// Returns the largest number for one call of an honest participant, less those for each octet.
  std::uint64_t most_branches() const { return most_branches_; }
  std::size_t most_handshakes() const { return most_handshakes_; }
  const std::optional<Violation>& violation() const { return violation_; }
  const std::map<Guid, End>& ends() const { return ends_; }

 private:
  void check_content(const End& reader, const Change& change);
  void check_order(const End& reader, const Change& change);

  const Ledger& ledger_;
  const Protection& protection_;
  const MonotonicTime& now_;
  std::map<Guid, End> ends_;
  std::map<std::pair<Guid, Guid>, SequenceNumber> latest_;  ///< by reader and writer
  /// For each writer, when it was heard late.
  std::map<Guid, std::set<MonotonicTime>> late_signs_;
  std::int64_t max_octets_ = kMaxOctets;
  std::uint64_t most_branches_ = 0;
  std::size_t most_handshakes_ = 0;
  bool besieged_ = false;
  MonotonicTime besieged_since_{};
  std::optional<Violation> violation_;
};

std::string describe(const End& end);

}  // namespace ddssec::rtps::sim
