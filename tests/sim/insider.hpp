// Modified products: the plugins of participants that have certificates and break the rules.
#pragma once

#include "tests/sim/mangle.hpp"
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"

namespace ddssec::rtps::sim {

/// The settings and knowledge that the hostile participants of a world share.
struct Malice {
  Dice dice{0};
  unsigned tampers = 0;  ///< how many in a thousand of its messages it changes
  /// In how many of a thousand steps it sends keys in another's name, by a stolen key.
  unsigned false_keys = 0;
  Dice further{0};  ///< for kinds of attacks that were added later
  /// In how many of a thousand announcements of its endpoints it claims another's.
  unsigned claims = 0;
  std::vector<GuidPrefix> names = {};
  std::function<Guid(bool writes)> endpoint = {};  ///< returns an endpoint of an honest participant
  /// Returns those of others, to be sent in a message of its own.
  std::function<Bytes()> submessages = {};
  testing::KeyThief::Stolen stolen = {};
};

/// Returns an access control that allows its own side everything, so that only the other side can
/// refuse. `borrowed` are the permissions that it sends, if they are not its own.
std::unique_ptr<spi::AccessControl> permissive(std::unique_ptr<spi::AccessControl> real,
                                               std::string borrowed);
/// Returns a cryptography plugin that changes what it is about to protect, and keeps all keys that
/// it is given.
std::unique_ptr<spi::Cryptography> tampering(std::unique_ptr<spi::Cryptography> real,
                                             Malice& malice);
/// Returns an authentication plugin that uses `name` instead of the GUID that its certificate
/// allows.
std::unique_ptr<spi::Authentication> under_false_name(std::unique_ptr<spi::Authentication> real,
                                                      const GuidPrefix& name);

}  // namespace ddssec::rtps::sim
