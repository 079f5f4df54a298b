// Measures what each participant costs: memory that its calls allocate and do not free, and
// branches that its protocol takes. The product's sources are compiled once more for this, with a
// call at each branch (see CMakeLists.txt).
#pragma once

#include <cstdint>

namespace ddssec::rtps::sim {

struct Cost {
  std::int64_t octets = 0;       ///< held now
  std::uint64_t branches = 0;    ///< taken so far
  std::int64_t most_octets = 0;  ///< the most that was held at the end of a call
};

/// While it lives, allocations and branches are charged to `cost`; another one inside it interrupts
/// it.
class Charge {
 public:
  explicit Charge(Cost& cost);
  ~Charge();
  Charge(const Charge&) = delete;
  Charge& operator=(const Charge&) = delete;

 protected:
  explicit Charge(Cost* cost);

 private:
  void resume();
  void pause();
  Cost* cost_;
  Charge* outer_;
  std::int64_t octets_ = 0;
  std::uint64_t branches_ = 0;
};

/// While it lives, no participant is charged: for the simulation's own work inside a participant's
/// call.
class FreeOfCharge : private Charge {
 public:
  FreeOfCharge() : Charge(nullptr) {}
};

}  // namespace ddssec::rtps::sim
