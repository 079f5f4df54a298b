// T34 (docs/attacks.md): peers with strange certificates. They are refused or accepted, but they
// cost little time and cause no crash.
#include <fstream>
#include <iterator>

#include "tests/support/test_data.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

// A participant of ours that waits for a request.
struct Victim {
  Victim() : us(plugin, make_identity(test_ca(), "CN=ours", {}, kYear, 1), 1) {}

  // Returns the result for a request whose c.id is `pem` and whose GUID fits `certificate`, if any.
  Result<spi::Authentication::HandshakeStep> receive(Bytes pem,
                                                     const pki::Certificate* certificate) {
    HandMadePeer shape(make_identity(test_ca(), "CN=shape"), 9);
    Guid guid = shape.guid();
    if (certificate != nullptr)
      guid = adjusted_guid(certificate->subject_digest(), candidate(9));
    else
      guid.prefix.octets[0] = 0x80;
    const auto remote =
        plugin->validate_remote_identity(us.handle, {}, {"DDS:Auth:PKI-DH:1.0"}, guid);
    if (!remote) return std::unexpected(remote.error());
    Token request = shape.request(pki::KeyAgreementKind::ecdh_p256, {});
    request = with(with(request, "c.id", std::move(pem)), "c.pdata", participant_data(guid));
    return plugin->begin_handshake_reply(without(request, "hash_c1"), remote->handle, us.handle,
                                         us.data);
  }

  TestPlugin plugin;
  Participant us;
};

// Returns a subject whose GUID is lower than that of `CN=ours`. The attacker chooses its name.
std::string low_subject(const std::string& rest) {
  const auto ours = adjusted_guid(
      make_identity(test_ca(), "CN=ours", {}, kYear, 1).certificate.subject_digest(), candidate(1));
  for (int i = 0;; ++i) {
    auto subject = "CN=" + std::to_string(i) + rest;
    const auto certificate = make_identity(test_ca(), subject).certificate;
    if (adjusted_guid(certificate.subject_digest(), candidate(9)) < ours) return subject;
  }
}

TEST(StrangeCertificate, AMegabyte_IsRefusedBySize) {
  Victim victim;
  EXPECT_CODE(victim.receive(Bytes(1024 * 1024, 'A'), nullptr), token_field_length);
  auto padded = bytes(test_ca().certificate().pem());
  padded.resize(1024 * 1024, '\n');
  EXPECT_CODE(victim.receive(padded, nullptr), token_field_length);
}

TEST(StrangeCertificate, AnHonestOne_IsTaken) {
  Victim victim;
  const auto identity = make_identity(test_ca(), low_subject(",O=Example"));
  EXPECT_TRUE(victim.receive(bytes(identity.certificate.pem()), &identity.certificate));
}

TEST(StrangeCertificate, SeveralAttributesInOneRdn_AreTaken) {
  Victim victim;
  const auto identity = make_identity(test_ca(), low_subject("+OU=unit+L=place,O=Example"));
  EXPECT_TRUE(victim.receive(bytes(identity.certificate.pem()), &identity.certificate));
}

TEST(StrangeCertificate, GarbageInItsText_IsRefusedWhereverItIs) {
  Victim victim;
  const auto identity = make_identity(test_ca(), low_subject(",O=Example"));
  const auto pem = bytes(identity.certificate.pem());
  std::size_t accepted = 0, total = 0;
  for (std::size_t at = 0; at < pem.size(); at += 3, ++total)
    accepted += victim.receive(flipped(pem, at), &identity.certificate).has_value();
  // A changed line end may become a character that PEM readers skip, and the certificate stays the
  // same.
  EXPECT_LT(accepted, total / 20);
  for (std::size_t size = 0; size + 2 < pem.size(); size += 5)
    EXPECT_FALSE(victim.receive(Bytes(pem.begin(), pem.begin() + static_cast<std::ptrdiff_t>(size)),
                                &identity.certificate))
        << size;
}

TEST(StrangeCertificate, AThousandAttributes_AreRefusedOrNeverIssued) {
  Victim victim;
  std::string subject = "CN=long";
  for (int i = 0; i < 1000; ++i) subject += ",OU=" + std::to_string(i);
  const auto certificate =
      test_ca().certify({.subject = subject, .validity = kYear}, key_of({}), test_random());
  // Our own authority does not make such a certificate, but OpenSSL's command does.
  ASSERT_FALSE(certificate);
  const auto pem = [] {
    std::ifstream in(test::data_path("strange-certificates/thousand-rdns.pem"));
    return std::string(std::istreambuf_iterator<char>(in), {});
  }();
  ASSERT_FALSE(pem.empty());
  EXPECT_CODE(victim.receive(bytes(pem), nullptr), name_not_allowed);
}

TEST(StrangeCertificate, ANulInTheName_IsRefused) {
  Victim victim;
  std::ifstream in(test::data_path("strange-certificates/nul-in-cn.pem"));
  const std::string pem(std::istreambuf_iterator<char>(in), {});
  ASSERT_FALSE(pem.empty());
  EXPECT_CODE(victim.receive(bytes(pem), nullptr), name_not_allowed);
}

}  // namespace
}  // namespace ddssec::authentication
