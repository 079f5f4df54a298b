// A participant whose certificate and key are files that are renewed while it runs.
#pragma once

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {

using std::chrono::days;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

inline constexpr auto kAlice = "CN=alice,O=Example";
inline constexpr pki::Validity kLater{kNow, kNow + days(500)};

/// Returns a CA that lives longer than the certificates that it issues.
inline const pki::Authority& long_lived_ca() {
  static const auto ca =
      make_ca("CN=Identity CA,O=Example", {}, {kNow - days(2), kNow + days(2000)});
  return ca;
}
inline const Identity& first_of_alice() {
  static const auto identity = make_identity(long_lived_ca(), kAlice);
  return identity;
}
inline const Identity& bob_of_it() {
  static const auto identity =
      make_identity(long_lived_ca(), "CN=bob,O=Example", {}, {kNow - 24h, kNow + days(1900)}, 1);
  return identity;
}

/// Returns a certificate of Alice that begins now, with one of the keys of the tests.
inline Identity renewed(int key = 0, pki::Validity validity = kLater, std::string subject = kAlice,
                        KeySpec spec = {}, const pki::Authority& ca = long_lived_ca()) {
  return make_identity(ca, std::move(subject), spec, validity, key);
}

/// Alice has files. Bob has none.
class Renewal : public testing::Test {
 protected:
  explicit Renewal(const Identity& first = first_of_alice())
      : certificate_path_(folder_.write("cert.pem", first.certificate.pem())),
        key_path_(folder_.write("key.pem", pem_text(first.key))),
        pairing_(with_files(first), bob_of_it()) {}

  Identity with_files(Identity identity) const {
    set(identity.properties, property::kIdentityCertificate, "file:" + certificate_path_);
    set(identity.properties, property::kPrivateKey, "file:" + key_path_);
    return identity;
  }
  void put(const Identity& identity) {
    folder_.replace("cert.pem", identity.certificate.pem());
    folder_.replace("key.pem", pem_text(identity.key));
  }
  std::vector<IdentityHandle> poll() { return plugin().poll(); }
  std::vector<Code> codes_after_looking() { return plugin().codes_after_looking(); }
  /// It is not taken, and that is said once.
  void expect_refused(const Identity& identity, std::string_view field, std::string_view expected,
                      std::string_view found) {
    put(identity);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_renewal_refused));
    ASSERT_FALSE(events().empty());
    const auto& error = events().front().error;
    EXPECT_EQ(error.details().document, certificate_path_);
    EXPECT_EQ(error.details().field, field);
    EXPECT_EQ(error.details().expected, expected);
    EXPECT_EQ(error.details().found, found);
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
    EXPECT_EQ(presented(), first_of_alice().certificate.pem());
  }
  /// Returns c.id of a handshake that begins now, with a new peer.
  std::string presented() {
    TestPlugin plugin_of_carol{7};
    Participant carol(plugin_of_carol,
                      make_identity(long_lived_ca(), "CN=carol,O=Example", {}, kYear, 2),
                      ++carols_);
    Two two(pairing_.a, carol);
    const auto request = two.request();
    EXPECT_TRUE(request);
    if (&two.low == &pairing_.a) return std::string(as_text(field(*request->message, "c.id")));
    const auto reply = two.reply(*request->message);
    EXPECT_TRUE(reply);
    return std::string(as_text(field(*reply->message, "c.id")));
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }
  std::vector<Event>& events() { return plugin().events.all; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }

  const test::TemporaryFolder folder_;
  const std::string certificate_path_, key_path_;
  Pairing pairing_;
  std::uint8_t carols_ = 10;
};

}  // namespace ddssec::authentication
