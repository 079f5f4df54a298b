// Limits how often one folder gets a new certificate or extended permissions.
#pragma once

#include <chrono>

namespace ddssec::cli {

/// How often the CA has answered for one folder. The owner of a folder can put a former certificate
/// back, which is due again, or throw each new one away. Each answer of a CA on this machine adds
/// lines to its log, which all commands read and which may not grow without limit. Answers of a
/// hook count only if the participant accepts them: after others there is a pause anyway, and the
/// reason for which they are refused must be seen.
class RenewalLimit {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  /// So many answers may follow each other at once. After that, there is one in each pause.
  static constexpr int kAtOnce = 2;

  /// Notes an answer of the CA. The pause is a twelfth of the certificate's lifetime (1 s to 1 h).
  void note(std::chrono::seconds lifetime, Moment now);
  /// True if the CA may be asked now.
  bool allows(Moment now) const { return used_until_ - now <= pause_ * (kAtOnce - 1); }
  /// Forgets the answers so far.
  void clear() { used_until_ = {}; }

 private:
  Moment pause_{0};
  Moment used_until_{0};  ///< from this time on, kAtOnce answers are allowed again
};

}  // namespace ddssec::cli
