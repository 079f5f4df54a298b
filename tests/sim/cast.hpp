// The participants of a simulation, their rights, and the protection of the domain.
#pragma once

#include <array>
#include <string>

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::sim {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// The topics have names of equal length, so that a hostile announcement can exchange one for
/// another in place.
inline constexpr std::array<std::string_view, 3> kTopics = {"Square", "Circle", "Sphere"};

inline constexpr std::array<std::string_view, 2> kTags = {"north", "south"};

enum class Role : std::uint8_t {
  honest,
  insider,    ///< has a certificate and some permissions, and a modified product
  forger,     ///< has a certificate, and permissions for everything that it signed itself
  impostor,   ///< has a certificate, and the GUID of an honest participant
  borrower,   ///< has a certificate, and the signed permissions of an honest participant
  foreign,    ///< has a certificate of another CA of the same name, with an honest subject
  elsewhere,  ///< honest, with all permissions, in another domain tag
  sibling,    ///< one of many participants with one certificate, without endpoints
};

struct Subject {
  std::string name;  ///< the name in the common name
  Role role = Role::honest;
  std::vector<std::string> publishes = {}, subscribes = {};

  bool may(bool write, std::string_view topic) const {
    const auto& list = write ? publishes : subscribes;
    return role != Role::forger && role != Role::impostor && role != Role::foreign &&
           role != Role::borrower && std::ranges::find(list, topic) != list.end();
  }
  bool is_honest() const { return role == Role::honest || role == Role::elsewhere; }
  std::string domain_tag() const { return std::string(kTags[role == Role::elsewhere ? 1 : 0]); }
};

/// A governance, and what it promises.
struct Protection {
  std::string_view name;
  testing::Rules rules;
  bool hides = true;             ///< only holders of a key read samples
  bool covers_headers = true;    ///< only holders of a key remove samples, by HEARTBEAT or GAP
  bool covers_times = false;     ///< only holders of a key change source timestamps
  bool separates_topics = true;  ///< no participant reads a topic that it may not read
  bool dates_readers = true;     ///< a reader that is made later gets nothing recorded before
  bool tells_readers_from_writers = false;  ///< origin authentication of samples
  bool hides_strangers = false;             ///< a pre-shared key protects the rest
};
std::span<const Protection> protections();

/// Returns the properties of a participant. Its certificate and documents are made once for each
/// subject and governance.
spi::PropertyList properties_of(const Subject& subject, const Protection& protection);
/// Returns the signed permissions of an honest participant, as a handshake carries them.
std::string honest_permissions(const Protection& protection);

}  // namespace ddssec::rtps::sim
