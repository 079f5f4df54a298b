// A participant without a network that has two protections at a time.
#pragma once

#include "rtps/security/protection_phases.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {

/// The keys of one participant, a known peer, and a reader that may have a pair with its writer.
struct Phases {
  Phases(ProtectionKind first, ProtectionKind second, bool revises_keys = false)
      : properties(properties_of("CN=alice,O=Example", rules(first, revises_keys))),
        host(1, properties),
        own(*OwnSecurity::create(
            {{*host.authentication, *host.access_control, *host.cryptography}, properties}, 0,
            Node::candidate(2))),
        keys(*own, remotes),
        phases(*own, remotes, locals, keys) {
    auto attributes = own->attributes();
    attributes.rtps = second;
    EXPECT_TRUE(phases.messages().add_second(attributes));
    remotes[peer] = {};
  }
  static Rules rules(ProtectionKind rtps, bool revises_keys) {
    Rules out{.rtps = rtps};
    out.revises_keys = revises_keys;
    return out;
  }
  bool must_protect() const { return phases.must_protect_messages(peer); }
  /// Adds a reader that has a pair of keys under both protections.
  void add_endpoint(ProtectionKind first, ProtectionKind second) {
    spi::EndpointSecurityAttributes attributes;
    attributes.submessage = first;
    EXPECT_TRUE(keys.add(locals, reader, LocalKeys{attributes}));
    locals.at(reader).pairs[writer] = {};
    attributes.submessage = second;
    EXPECT_TRUE(phases.endpoints().add(reader, attributes));
    phases.endpoints().set_permitted(reader, writer, true);
    phases.endpoints().find(reader, protection_id(attributes))->pairs[writer] = {};
  }
  ProtectionKind demanded() const { return phases.demanded(reader, writer)->attributes.submessage; }

  const spi::PropertyList properties;
  const GuidPrefix peer = Node::candidate(9);
  const EntityId reader{{0, 0, 1, 7}};
  const Guid writer{peer, EntityId{{0, 0, 1, 2}}};
  Node host;
  std::unique_ptr<OwnSecurity> own;
  Remotes remotes;
  Locals locals;
  EndpointKeys keys;
  ProtectionPhases phases;
};

}  // namespace ddssec::rtps::testing
