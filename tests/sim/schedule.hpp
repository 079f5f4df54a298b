// The events of a run: drawn from its seed, and carried out.
#pragma once

#include "tests/sim/world.hpp"

namespace ddssec::rtps::sim {

struct Plan {
  std::uint64_t seed = 0;
  const Protection* protection = nullptr;
  std::vector<Subject> cast;
  Temper temper = {};
  /// The attacks while everything that is sent arrives, and the attackers only add to it. In a long
  /// siege a participant that died at its beginning must be forgotten.
  Temper siege = {};
  int siege_steps = 0;
  bool siege_restart = false;  ///< a participant restarts without a dispose at its beginning
  unsigned tampers = 0;        ///< see Malice
  int hostile_steps = 0;
  bool meets_first = false;  ///< the participants meet before the network is hostile
  bool sparse = false;       ///< late readers of a writer that has used up a million numbers
  unsigned false_keys = 0;   ///< see Malice
  unsigned claims = 0;       ///< see Malice
  // The following numbers are for a thousand steps.
  unsigned writes = 0, restarts = 0, sleeps = 0, calendars = 0, endpoints = 0;
};

/// Draws the plan of a seed. `steps` is the number of hostile steps; with 0 the seed decides.
Plan plan_of(std::uint64_t seed, int steps = 0);
/// Describes the plan in one line.
std::string describe(const Plan& plan);

struct Outcome {
  std::optional<Violation> violation;
  long step = 0;  ///< the step of the violation, or the last one
  std::uint64_t fingerprint = 0;
  std::uint64_t datagrams = 0;      ///< the number that arrived
  Cost most;                        ///< the cost of the honest node that took the most memory
  std::uint64_t most_branches = 0;  ///< the largest number for one call
  std::size_t most_handshakes = 0;  ///< the largest number that one call began
  MonotonicTime reunion{};          ///< how long honest pairs took once the network was fair
};
Outcome run(const Plan& plan);

}  // namespace ddssec::rtps::sim
