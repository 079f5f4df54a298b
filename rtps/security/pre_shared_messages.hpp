// Messages under the key that the domain shares (DDS-Security 1.2 10.4.1.2.5.8).
#pragma once

#include "base/event.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/reliability/send_protection.hpp"
#include "rtps/security/own_security.hpp"
#include "wire/header.hpp"

namespace ddssec::rtps {

/// Counts of what was dropped on receipt; never reset.
struct ProtectionCounters {
  std::uint64_t unprotected = 0;  ///< protection was due and not there
  std::uint64_t undecodable = 0;  ///< protected, but not so that it verified
  std::uint64_t unsendable = 0;   ///< could not be protected, so was not sent
};

/// Does nothing where the governance has no rtps_psk_protection_kind.
class PreSharedMessages {
 public:
  /// Senders that were not heard before cost us keys: so many at once, then one each so long.
  static constexpr int kMaxDerivations = 1000;
  static constexpr MonotonicTime kDerivationPeriod = std::chrono::microseconds(100);
  /// Events of messages that any sender can send.
  static constexpr int kMaxComplaints = 16;
  static constexpr MonotonicTime kComplaintPeriod = std::chrono::milliseconds(250);

  /// Everything is borrowed.
  PreSharedMessages(OwnSecurity& own, EventSink& events, ProtectionCounters& counters)
      : own_(own), events_(events), counters_(counters) {}

  bool are_due() const { return own_.pre_shared_keys() != nullptr; }
  /// Of what no participant's own key protects.
  SendProtection::Wrap wrap() const {
    return are_due() ? SendProtection::Wrap::pre_shared_key : SendProtection::Wrap::none;
  }
  /// A message that has the pre-shared key's flag. Errors: those of the key, and
  /// secure_flags_unsupported where we have none.
  Result<BytesView> open(const Header& header, BytesView message, MutableBytes scratch,
                         MonotonicTime now);
  /// A message that is not protected, where it is due. Error: rtps_protection_missing.
  std::unexpected<Error> refuse_bare(const Header& header, MonotonicTime now);
  /// Error: not_protected where we have no key.
  Result<std::size_t> protect(BytesView plain, MutableBytes out);

 private:
  std::unexpected<Error> complain(Code code, const Header& header, std::string_view expected,
                                  MonotonicTime now);

  OwnSecurity& own_;
  EventSink& events_;
  ProtectionCounters& counters_;
  WorkBudget derivations_{kMaxDerivations, kDerivationPeriod, {}};
  WorkBudget complaints_{kMaxComplaints, kComplaintPeriod, {}};
};

}  // namespace ddssec::rtps
