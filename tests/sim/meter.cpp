#include "tests/sim/meter.hpp"

#include <algorithm>

#include "tests/support/counted_memory.hpp"

namespace {
std::uint64_t branches_taken = 0;
}
extern "C" void __sanitizer_cov_trace_pc();
void __sanitizer_cov_trace_pc() { ++branches_taken; }

namespace ddssec::rtps::sim {
namespace {
Charge* current = nullptr;
}

Charge::Charge(Cost& cost) : Charge(&cost) {}

Charge::Charge(Cost* cost) : cost_(cost), outer_(current) {
  if (outer_ != nullptr) outer_->pause();
  current = this;
  resume();
}

Charge::~Charge() {
  pause();
  if (cost_ != nullptr) cost_->most_octets = std::max(cost_->most_octets, cost_->octets);
  current = outer_;
  if (outer_ != nullptr) outer_->resume();
}

void Charge::resume() {
  octets_ = counted_memory::octets();
  branches_ = branches_taken;
}

void Charge::pause() {
  if (cost_ == nullptr) return;
  cost_->octets += counted_memory::octets() - octets_;
  cost_->branches += branches_taken - branches_;
}

}  // namespace ddssec::rtps::sim
