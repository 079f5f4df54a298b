// Messages protected with the pre-shared key of the domain (DDS-Security 1.2, clause 10.4.1.2.5.8).
#pragma once

#include "base/event.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/reliability/send_protection.hpp"
#include "rtps/security/own_security.hpp"
#include "rtps/security/security_counters.hpp"
#include "wire/header.hpp"

namespace ddssec::rtps {

/// Protects and opens messages with the pre-shared key. Does nothing if the governance has no
/// rtps_psk_protection_kind.
class PreSharedMessages {
 public:
  /// Limits for key derivations, which each new sender causes: a burst, then one per period.
  static constexpr int kMaxDerivations = 1000;
  static constexpr MonotonicTime kDerivationPeriod = std::chrono::microseconds(100);
  /// Limits for events about messages that any sender can send.
  static constexpr int kMaxComplaints = 16;
  static constexpr MonotonicTime kComplaintPeriod = std::chrono::milliseconds(250);

  /// All arguments are borrowed and must outlive this object.
  PreSharedMessages(OwnSecurity& own, EventSink& events, ProtectionCounters& counters)
      : own_(own), events_(events), counters_(counters) {}

  bool are_due() const { return own_.pre_shared_keys() != nullptr; }
  /// Returns the protection of messages that no participant's own key protects.
  SendProtection::Wrap wrap() const {
    return are_due() ? SendProtection::Wrap::pre_shared_key : SendProtection::Wrap::none;
  }
  /// Opens a message that has the pre-shared key's flag. Errors: those of the key, and
  /// secure_flags_unsupported if there is no pre-shared key.
  Result<BytesView> open(const Header& header, BytesView message, MutableBytes scratch,
                         MonotonicTime now);
  /// Refuses an unprotected message where protection is required. Returns the error
  /// rtps_protection_missing.
  std::unexpected<Error> missing_protection_error(const Header& header, MonotonicTime now);
  /// Protects a message. Error: not_protected if there is no key.
  Result<std::size_t> protect(BytesView plain, MutableBytes out);

 private:
  std::unexpected<Error> report_error(Code code, const Header& header, std::string_view expected,
                                      MonotonicTime now);

  OwnSecurity& own_;
  EventSink& events_;
  ProtectionCounters& counters_;
  WorkBudget derivations_{kMaxDerivations, kDerivationPeriod, {}};
  WorkBudget complaints_{kMaxComplaints, kComplaintPeriod, {}};
};

}  // namespace ddssec::rtps
