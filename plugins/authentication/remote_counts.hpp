// How many remote identities a local one may have, and how many of them one certificate.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <string>

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::authentication {

/// Of each local identity.
struct RemoteLimits {
  std::size_t most_claimed;        ///< that have not authenticated
  std::size_t most_authenticated;  ///< that have
  std::size_t most_of_a_subject;   ///< of these, of one subject
};

/// Counts the remote identities of one local identity. Those that have authenticated are counted by
/// subject, for which the first six octets of the GUID stand (DDS-Security 9.3.3): anyone can claim
/// them, so claims are only counted together. One certificate never takes the last places: a
/// subject may have no more of them than are free, and so each further subject finds some. Not
/// thread-safe.
class RemoteCounts {
 public:
  /// May a GUID be admitted that has proven nothing? Errors: too_many_remote_identities,
  /// too_many_identities_of_subject.
  Status check_claim(const Guid& guid, const RemoteLimits& limits) const;
  /// May the owner of the GUID authenticate? Errors as above.
  Status check_authenticated(const Guid& guid, const RemoteLimits& limits) const;

  void add_claim() { ++claimed_; }
  /// A claim was proven.
  void authenticate(const Guid& guid, std::string subject);
  /// Needs no memory.
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
