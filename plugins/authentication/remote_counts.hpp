// Limits for the number of remote identities of one local identity, in total and for one
// certificate.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::authentication {

/// Limits for each local identity.
struct RemoteLimits {
  std::size_t max_claimed;        ///< identities that have not authenticated
  std::size_t max_authenticated;  ///< identities that have authenticated
  std::size_t max_of_a_subject;   ///< of these, identities of one subject
};

/// Counts the remote identities of one local identity.
///
/// Authenticated identities are counted by subject, represented by the first six octets of the GUID
/// (DDS-Security 1.2, clause 10.3.3). Any participant can claim these octets, so unproven claims
/// are only counted in total. One certificate never takes the last places: a subject may have at
/// most as many places as are free, so each further subject still finds some. Not thread-safe.
class RemoteCounts {
 public:
  /// Success if an unproven GUID may be admitted. Errors: too_many_remote_identities,
  /// too_many_identities_of_subject.
  Status check_claim(const Guid& guid, const RemoteLimits& limits) const;
  /// Success if the owner of the GUID may authenticate. Errors as above.
  Status check_authenticated(const Guid& guid, const RemoteLimits& limits) const;

  void add_claim() { ++claimed_; }
  /// Moves a claim to the authenticated identities.
  void authenticate(const Guid& guid, std::string subject);
  /// Removes one identity. Allocates no memory.
  void remove(const Guid& guid, bool authenticated);

 private:
  using Half = std::array<std::uint8_t, 6>;
  struct Subject {
    std::string name;
    std::size_t count = 0;
  };
  static Half half_of(const Guid& guid);

  std::size_t claimed_ = 0;
  std::size_t authenticated_ = 0;
  std::map<Half, Subject> subjects_;
};

}  // namespace ddssec::authentication
