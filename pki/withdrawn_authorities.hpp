// The CAs that a running participant has ceased to trust.
#pragma once

#include <set>
#include <vector>

#include "base/hash.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"

namespace ddssec::pki {

/// A CA file has no number or date that would show which of two is the newer one. So a CA that has
/// left the file does not come back while the participant runs: else an attacker who can write the
/// folder would undo its end by putting the former file back. Not thread-safe.
class WithdrawnAuthorities {
 public:
  /// The largest number of certificates that are remembered. With so many, a change that withdraws
  /// another one is refused.
  static constexpr std::size_t kMaxWithdrawn = 256;

  /// May `next` take the place of `former`? Error: ca_put_back.
  Status check(const std::vector<Certificate>& former, const std::vector<Certificate>& next) const;
  /// It has. Call it after `check` succeeded.
  void note(const std::vector<Certificate>& former, const std::vector<Certificate>& next);

 private:
  std::set<Sha256Digest> withdrawn_;
};

/// Subjects and first digits of the fingerprints, for a person; of at most 512 characters.
std::string describe(const std::vector<Certificate>& authorities);

}  // namespace ddssec::pki
