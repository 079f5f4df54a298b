// Modified products: the plugins of participants that have certificates and break the rules.
#pragma once

#include "tests/sim/mangle.hpp"
#include "tests/unit/rtps_security/forwarding_authentication.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"

namespace ddssec::rtps::sim {

/// What the hostile participants of a world share.
struct Malice {
  Dice dice{0};
  unsigned tampers = 0;     ///< with so many in a thousand of its messages
  unsigned false_keys = 0;  ///< in a thousand steps: keys in another's name, by a stolen key
  Dice further{0};          ///< for kinds of attacks that were added later
  unsigned claims = 0;      ///< in a thousand announcements of its endpoints: another's endpoint
  std::vector<GuidPrefix> names = {};
  std::function<Guid(bool writes)> endpoint = {};  ///< of an honest participant
  std::function<Bytes()> submessages = {};  ///< of others, to be sent in a message of its own
  testing::KeyThief::Stolen stolen = {};
};

/// Allows its own side everything, so that only the other side can refuse. `borrowed`: the
/// permissions that it sends, if they are not its own.
std::unique_ptr<spi::AccessControl> permissive(std::unique_ptr<spi::AccessControl> real,
                                               std::string borrowed);
/// Changes what it is about to protect, and keeps all keys that it is given.
std::unique_ptr<spi::Cryptography> tampering(std::unique_ptr<spi::Cryptography> real,
                                             Malice& malice);
/// Takes `name` for the GUID that its certificate allows.
std::unique_ptr<spi::Authentication> under_false_name(std::unique_ptr<spi::Authentication> real,
                                                      const GuidPrefix& name);

}  // namespace ddssec::rtps::sim
