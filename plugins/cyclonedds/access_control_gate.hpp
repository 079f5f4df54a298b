// spi::MatchGate across two shared libraries: libddssec_cryptography asks libddssec_access_control.
#pragma once

#include <memory>
#include <vector>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/spi/match_gate.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cyclonedds {

/// Asks access control in the other library whether a pair may match.
class AccessControlGate final : public spi::MatchGate {
 public:
  /// Returns the gate of an endpoint with these ac_endpoint_properties; nullptr with a stock access
  /// control plugin, which cannot be asked. Errors: null_argument, length_out_of_range.
  static Result<std::shared_ptr<const AccessControlGate>> of(
      const DDS_Security_PropertySeq& properties);

  /// If `judge` is null, it is looked up in the process for each question.
  explicit AccessControlGate(spi::PropertyList scope, JudgeMatch* judge = nullptr);
  Status check(const Peer& peer) const override;

 private:
  spi::PropertyList scope_;
  std::vector<DDS_Security_Property_t> as_c_;  ///< borrows from scope_
  JudgeMatch* const judge_;
};

}  // namespace ddssec::cyclonedds
