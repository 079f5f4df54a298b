// The files that the properties of a participant name. Each must exist and fit the others;
// otherwise it is refused by its name.
#include "plugins/authentication/identity_files.hpp"

#include <gmock/gmock.h>

#include "plugins/authentication/own_identity.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/local_identities.hpp"

namespace ddssec::authentication::local_identities {
namespace {

Identity alice() { return make_identity(test_ca(), "CN=alice,O=Example"); }

PropertyList alice_with(std::string_view name, std::string value) {
  auto properties = alice().properties;
  set(properties, name, std::move(value));
  return properties;
}

using test::TemporaryFolder;

// Returns what create() says about Alice's documents in files, after `change(files, properties)`.
template <class Change>
std::string sentence_about_files(const TemporaryFolder& folder, Change&& change) {
  auto properties = alice().properties;
  for (const auto& [name, file] : {std::pair{property::kIdentityCa, "ca.pem"},
                                   {property::kIdentityCertificate, "cert.pem"},
                                   {property::kPrivateKey, "key.pem"}}) {
    const auto text = spi::find_property(properties, name)->substr(6);  // the text after "data:,"
    set(properties, name, "file:" + folder.replace(file, text));
  }
  change();
  TestPlugin plugin;
  const auto result = create(properties, plugin);
  return result ? "" : result.error().to_sentence();
}

TEST(IdentityFileErrors, Refused_NamesPropertyAndPath) {
  const TemporaryFolder folder;
  const auto names = [&](std::string_view property, std::string_view file) {
    return testing::HasSubstr(std::string(property) + " is " + folder.path() + "/" +
                              std::string(file));
  };
  const auto other_key = pem_text(make_identity(test_ca(), "CN=bob", {}, kYear, 1).key);
  const auto mismatch = sentence_about_files(folder, [&] { folder.replace("key.pem", other_key); });
  EXPECT_THAT(mismatch, names(property::kPrivateKey, "key.pem"));
  EXPECT_THAT(mismatch, names(property::kIdentityCertificate, "cert.pem"));
  const auto unknown = sentence_about_files(
      folder, [&] { folder.replace("ca.pem", make_ca("CN=Other").certificate().pem()); });
  EXPECT_THAT(unknown, names(property::kIdentityCertificate, "cert.pem"));
  EXPECT_THAT(unknown, names(property::kIdentityCa, "ca.pem"));
  for (const auto& [property, file] : {std::pair{property::kIdentityCa, "ca.pem"},
                                       {property::kIdentityCertificate, "cert.pem"},
                                       {property::kPrivateKey, "key.pem"}})
    EXPECT_THAT(sentence_about_files(folder, [&] { folder.replace(file, "-----BEGIN"); }),
                names(property, file));
}

TEST(IdentityFileErrors, PastedDocuments_AreNotRepeated) {
  auto properties = alice_with(property::kPrivateKey, "data:,-----BEGIN SECRET");
  TestPlugin plugin;
  const auto result = create(properties, plugin);
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().to_sentence(), testing::Not(testing::HasSubstr("SECRET")));
}

TEST(OwnIdentityFiles, FilesOfEachUriForm_AreRead) {
  const TemporaryFolder folder;
  const auto identity = alice();
  for (const std::string prefix : {"file:", "file://", "  file:"}) {
    PropertyList properties;
    set(properties, property::kIdentityCa,
        prefix + folder.write("ca", test_ca().certificate().pem()));
    set(properties, property::kIdentityCertificate,
        prefix + folder.write("cert", identity.certificate.pem()));
    set(properties, property::kPrivateKey, prefix + folder.write("key", pem_text(identity.key)));
    EXPECT_TRUE(create(properties)) << prefix;
  }
}

TEST(OwnIdentityFiles, EmptyOptionalProperties_CountAsAbsent) {
  auto properties = alice().properties;
  for (const auto name : {property::kPassword, property::kTrustedCaDir, property::kCrl})
    set(properties, name, "");
  EXPECT_TRUE(create(properties));
}

TEST(OwnIdentityFiles, MissingProperties_AreNamed) {
  for (const auto name :
       {property::kIdentityCa, property::kIdentityCertificate, property::kPrivateKey}) {
    auto properties = alice().properties;
    std::erase_if(properties, [&](const auto& p) { return p.name == name; });
    expect_refused(properties, Code::missing_property, name);
    expect_refused(alice_with(name, ""), Code::missing_property, name);
    expect_refused(alice_with(name, "pkcs11:token=nowhere;object=x"), Code::pkcs11_not_found, name);
    expect_refused(alice_with(name, "http://x"), Code::unsupported_uri, name);
    expect_refused(alice_with(name, "file:/nowhere/at/all"), Code::file_not_found, name);
    expect_refused(alice_with(name, "data:,"), Code::item_empty, name);
  }
}

TEST(OwnIdentityFiles, Garbage_IsNamed) {
  expect_refused(alice_with(property::kIdentityCa, "data:,x"), Code::certificate_malformed,
                 property::kIdentityCa);
  expect_refused(alice_with(property::kIdentityCertificate, "data:,x"), Code::certificate_malformed,
                 property::kIdentityCertificate);
  expect_refused(alice_with(property::kPrivateKey, "data:,x"), Code::private_key_malformed,
                 property::kPrivateKey);
  expect_refused(alice_with(property::kCrl, "data:,x"), Code::crl_file_empty, property::kCrl);
  expect_refused(alice_with(property::kPassword, std::string(1025, 'x')), Code::invalid_property,
                 property::kPassword);
}

TEST(OwnIdentityFiles, KeyOfAnotherCertificate_IsRefused) {
  expect_refused(alice_with(property::kPrivateKey, "data:," + pem_text(key_of({}, 1))),
                 Code::key_mismatch, property::kPrivateKey);
  expect_refused(
      alice_with(property::kPrivateKey, "data:," + pem_text(key_of({KeyKind::rsa, 2048}))),
      Code::key_mismatch, property::kPrivateKey);
}

TEST(OwnIdentityFiles, OwnCertificate_MustBeUnderOwnCa) {
  const auto other = make_ca("CN=Other CA");
  expect_refused(alice_with(property::kIdentityCa, "data:," + other.certificate().pem()),
                 Code::issuer_unknown, property::kIdentityCertificate);
  // A CA of the same name with another key.
  const auto twin = make_ca();
  expect_refused(alice_with(property::kIdentityCa, "data:," + twin.certificate().pem()),
                 Code::issuer_unknown, property::kIdentityCertificate);
}

TEST(OwnIdentityFiles, ACaFileOfNoCa_IsRefused) {
  expect_refused(alice_with(property::kIdentityCa, "data:," + alice().certificate.pem()),
                 Code::not_a_ca, property::kIdentityCa);
}

TEST(OwnIdentityFiles, ExpiredAndNotYetValid_AreRefused) {
  expect_refused(make_identity(test_ca(), "CN=old", {}, {kNow - 48h, kNow - 1s}).properties,
                 Code::certificate_expired, property::kIdentityCertificate);
  expect_refused(make_identity(test_ca(), "CN=new", {}, {kNow + 1s, kNow + 48h}).properties,
                 Code::certificate_not_yet_valid, property::kIdentityCertificate);
  const auto old_ca = make_ca("CN=Old CA", {}, {kNow - 48h, kNow - 1s});
  expect_refused(make_identity(old_ca, "CN=alice").properties, Code::certificate_expired,
                 property::kIdentityCertificate);
}

TEST(OwnIdentityFiles, EncryptedKey_OpensWithThePassword) {
  const auto passphrase = pki::Passphrase::copy_of(as_bytes("sesame")).value();
  const auto pem = alice().key.to_pem(&passphrase).value().expose([](BytesView octets) {
    return std::string(as_text(octets));
  });
  auto properties = alice_with(property::kPrivateKey, "data:," + pem);
  expect_refused(properties, Code::passphrase_missing, property::kPrivateKey);
  set(properties, property::kPassword, "wrong");
  expect_refused(properties, Code::passphrase_wrong, property::kPrivateKey);
  set(properties, property::kPassword, "sesame");
  EXPECT_TRUE(create(properties));
}

TEST(TrustedCaDir, CaInTheFolder_IsBelieved) {
  const auto other = make_ca("CN=Other CA");
  const TemporaryFolder folder;
  folder.write("own.pem", test_ca().certificate().pem());
  folder.write("other.pem", other.certificate().pem());
  folder.write("readme.txt", "no certificate");
  folder.write("leaf.pem", alice().certificate.pem());
  auto a = alice();
  auto b = make_identity(other, "CN=bob", {}, kYear, 1);
  for (const std::string prefix : {"", "file:", "file://"}) {
    for (auto* identity : {&a, &b})
      set(identity->properties, property::kTrustedCaDir, prefix + folder.path());
    Pairing(a, b).expect_success();
  }
}

TEST(TrustedCaDir, UnusableFolders_AreRefusedWithTheirCodes) {
  const TemporaryFolder folder;
  const auto properties = alice_with(property::kTrustedCaDir, folder.path());
  expect_refused(properties, Code::own_ca_not_trusted, property::kTrustedCaDir);
  folder.write("own.pem", test_ca().certificate().pem());
  EXPECT_TRUE(create(properties));
  auto both = properties;
  set(both, property::kCrl,
      "data:," +
          test_ca()
              .make_crl(
                  {.revoked = {}, .this_update = kYear.not_before, .next_update = kYear.not_after})
              .value()
              .pem());
  expect_refused(both, Code::trusted_ca_dir_with_crl, property::kTrustedCaDir);
  expect_refused(alice_with(property::kTrustedCaDir, folder.path() + "/none"),
                 Code::trusted_ca_dir_unreadable, property::kTrustedCaDir);
  std::string many;
  for (int i = 0; i < 101; ++i) many += test_ca().certificate().pem();
  folder.write("many.pem", many);
  expect_refused(properties, Code::trusted_ca_dir_too_many, property::kTrustedCaDir);
}

std::string crl_of(const pki::Authority& ca, std::vector<pki::Certificate> revoked,
                   pki::Validity when = kYear) {
  return ca
      .make_crl({.revoked = revoked, .this_update = when.not_before, .next_update = when.not_after})
      .value()
      .pem();
}

TEST(RevocationList, OwnCertificateOnTheList_IsRefused) {
  const auto identity = alice();
  auto properties = identity.properties;
  set(properties, property::kCrl, "data:," + crl_of(test_ca(), {}));
  EXPECT_TRUE(create(properties));
  set(properties, property::kCrl, "data:," + crl_of(test_ca(), {identity.certificate}));
  expect_refused(properties, Code::certificate_revoked, property::kIdentityCertificate);
}

TEST(RevocationList, ListThatDoesNotHelp_FailsHard) {
  const auto other = make_ca("CN=Other CA"), twin = make_ca();
  expect_refused(alice_with(property::kCrl, "data:," + crl_of(other, {})), Code::crl_missing,
                 property::kIdentityCertificate);
  expect_refused(
      alice_with(property::kCrl, "data:," + crl_of(test_ca(), {}, {kNow - 48h, kNow - 1h})),
      Code::crl_expired, property::kIdentityCertificate);
  expect_refused(
      alice_with(property::kCrl, "data:," + crl_of(test_ca(), {}, {kNow + 1h, kNow + 48h})),
      Code::crl_not_yet_valid, property::kIdentityCertificate);
  expect_refused(alice_with(property::kCrl, "data:," + crl_of(twin, {})), Code::crl_missing,
                 property::kIdentityCertificate);
  expect_refused(alice_with(property::kCrl, "data:," + test_ca().certificate().pem()),
                 Code::crl_file_empty, property::kCrl);
}

TEST(RevocationList, SoftFail_IsAnOption) {
  TestPlugin plugin(1, {.crl_policy = pki::CrlPolicy::soft_fail});
  EXPECT_TRUE(
      create(alice_with(property::kCrl, "data:," + crl_of(test_ca(), {}, {kNow - 48h, kNow - 1h})),
             plugin));
  const auto identity = alice();
  auto revoked = identity.properties;
  set(revoked, property::kCrl, "data:," + crl_of(test_ca(), {identity.certificate}));
  EXPECT_CODE(create(revoked, plugin), certificate_revoked);
}

TEST(RevocationList, SeveralLists_CountTogether) {
  const auto other = make_ca("CN=Other CA");
  const auto bob = make_identity(other, "CN=bob", {}, kYear, 1);
  auto a = alice();
  set(a.properties, property::kIdentityCa,
      "data:," + test_ca().certificate().pem() + other.certificate().pem());
  set(a.properties, property::kCrl,
      "data:," + crl_of(test_ca(), {}) + crl_of(other, {bob.certificate}));
  auto b = bob;
  set(b.properties, property::kIdentityCa,
      "data:," + test_ca().certificate().pem() + other.certificate().pem());
  Pairing pairing(a, b);
  const auto request = pairing.two.request();
  ASSERT_OK(request);
  const auto reply = pairing.two.reply(*request->message);
  if (&pairing.two.high == &pairing.a) {
    EXPECT_CODE(reply, certificate_revoked);
  } else {
    ASSERT_OK(reply);
    EXPECT_CODE(pairing.two.process_at_lower_guid(request->handle, *reply->message),
                certificate_revoked);
  }
}

}  // namespace
}  // namespace ddssec::authentication::local_identities
