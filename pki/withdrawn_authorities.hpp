// The CAs that a running participant has ceased to trust.
#pragma once

#include <set>
#include <vector>

#include "base/hash.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// Remembers CAs that have left a CA file, so that they do not come back while the participant
/// runs. A CA file has no number or date that shows which of two is newer. Otherwise an attacker
/// who can write the folder could make the participant trust the CA again by putting the former
/// file back. Not thread-safe.
class WithdrawnAuthorities {
 public:
  /// The largest number of certificates that are remembered. After that, a change that withdraws
  /// another one is refused.
  static constexpr std::size_t kMaxWithdrawn = 256;

  /// Succeeds if `next` may replace `former`. Error: ca_put_back.
  Status check(const std::vector<Certificate>& former, const std::vector<Certificate>& next) const;
  /// Notes that `next` has replaced `former`. Call it after `check` succeeded.
  void note(const std::vector<Certificate>& former, const std::vector<Certificate>& next);
  /// Lets these CAs come back. Call it only for a file that was read before it was whole.
  void forget(const std::vector<Certificate>& authorities);

 private:
  std::set<Sha256Digest> withdrawn_;
};

/// Returns the CAs of `former` that `next` lacks.
std::vector<Certificate> leaving(const std::vector<Certificate>& former,
                                 const std::vector<Certificate>& next);

/// Returns subjects and first digits of the fingerprints, for a person; at most 512 characters.
std::string describe(const std::vector<Certificate>& authorities);

}  // namespace ddssec::pki
