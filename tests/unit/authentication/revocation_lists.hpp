// Two identities and the revocation lists of their CA.
#pragma once

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {

namespace property = spi::property;

inline const Identity& alice() {
  static const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  return identity;
}
inline const Identity& bob() {
  static const auto identity = make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1);
  return identity;
}

struct List {
  std::uint64_t number = 1;
  std::vector<pki::Certificate> revoked = {};
  WallTime from = kNow - 1h;
  WallTime until = kYear.not_after;
};
inline std::string pem(const List& list, const pki::Authority& ca = test_ca()) {
  return ca
      .make_crl({.revoked = list.revoked,
                 .this_update = list.from,
                 .next_update = list.until,
                 .number = list.number})
      .value()
      .pem();
}

inline Identity with_list(Identity identity, const std::string& uri,
                          std::string_view name = property::kCrl) {
  set(identity.properties, name, uri);
  return identity;
}

}  // namespace ddssec::authentication
