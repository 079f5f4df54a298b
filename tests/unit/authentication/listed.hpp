// Peers whose certificates end, and a renewal list.
#pragma once

#include <gmock/gmock.h>

#include "pki/renewal_list.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication::listed {

using testing::ElementsAre;
using testing::HasSubstr;

inline constexpr auto kAlice = "CN=alice,O=Example";
inline constexpr auto kBob = "CN=bob,O=Example";
inline constexpr pki::Validity kShort{kNow - 24h, kNow + 20s};
inline constexpr pki::Validity kNext{kNow + 5s, kNow + 100 * 24h};

/// Returns an identity of Bob. His key has index 1.
inline Identity bob_with(pki::Validity validity, int key = 1, const pki::Authority& ca = test_ca(),
                         const std::string& subject = kBob) {
  return make_identity(ca, subject, {}, validity, key);
}

inline pki::Certificate renewed_bob(int key = 1, pki::Validity validity = kNext) {
  return bob_with(validity, key).certificate;
}

inline std::string list_of(std::vector<pki::Certificate> certificates) {
  return pki::RenewalList{.certificates = std::move(certificates)}.text().value();
}

/// Alice has files. Bob has a certificate that ends 20 seconds from now.
class Listed : public testing::Test {
 protected:
  explicit Listed(const std::string& crl = {}) : pairing_(with_files(crl), bob_) {}

  void SetUp() override {
    pairing_.expect_success();
    events().clear();
  }

  Identity with_files(const std::string& crl) const {
    auto identity = make_identity(test_ca(), kAlice);
    set(identity.properties, property::kIdentityCertificate,
        "file:" + folder_.write("cert.pem", identity.certificate.pem()));
    if (!crl.empty()) folder_.write("crl.pem", crl);
    return identity;
  }
  void put(const std::string& text) { folder_.replace("renewed.pem", text); }
  std::vector<IdentityHandle> poll(std::chrono::seconds after = 5s) { return plugin().poll(after); }
  /// Polls until a minute after the end of Bob's certificate. Returns the identities that ended.
  std::vector<IdentityHandle> pass_the_end() {
    std::vector<IdentityHandle> ended;
    for (int i = 0; i < 16; ++i)
      for (const auto handle : poll()) ended.push_back(handle);
    return ended;
  }
  std::vector<Code> codes() {
    const auto out = plugin().events.codes();
    events().clear();
    return out;
  }
  void expect_ends(std::string_view note) {
    EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
    ASSERT_FALSE(events().empty());
    const auto& error = events().back().error;
    EXPECT_EQ(error.code(), Code::identity_ended);
    EXPECT_EQ(events().back().peer_subject, kBob);
    EXPECT_THAT(error.details().note, HasSubstr(note));
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }
  std::vector<Event>& events() { return plugin().events.all; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }
  std::string path() const { return folder_.path() + "/renewed.pem"; }

  const test::TemporaryFolder folder_;
  const Identity bob_ = bob_with(kShort);
  Pairing pairing_;
};

}  // namespace ddssec::authentication::listed
