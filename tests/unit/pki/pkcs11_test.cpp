// Keys and certificates in a PKCS#11 token: that of SoftHSM, into which the tests import keys and a
// certificate.
#include "pki/pkcs11.hpp"

#include <cstdlib>
#include <filesystem>

#include "pki/login_ban.hpp"
#include "pki/signature.hpp"
#include "pki/smime.hpp"
#include "pki_fixture.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec::pki {
namespace {

constexpr auto kProperty = "dds.sec.auth.private_key";
constexpr auto kPin = "open sesame 1";

void run(const std::string& command) {
  ASSERT_EQ(std::system((command + " >/dev/null").c_str()), 0) << command;
}

// One token for all tests of the process, because its module is loaded only once.
class Pkcs11Token : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    std::filesystem::create_directory(folder_->path() + "/tokens");
    const auto configuration =
        folder_->write("softhsm2.conf", "directories.tokendir = " + folder_->path() +
                                            "/tokens\nlog.level = ERROR\n");
    ASSERT_EQ(setenv("SOFTHSM2_CONF", configuration.c_str(), 1), 0);
    run(with_pin_option("softhsm2-util --init-token --free --label robot --so-pin 87654321"));
    put("ec", KeyKind::ec_p256);
    put("p384", KeyKind::ec_p384);
    put("rsa", KeyKind::rsa);
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string with_pin_option(const std::string& command) {
    return command + " --pin '" + kPin + "'";
  }
  static void put(const std::string& name, KeyKind kind) {
    auto key = *PrivateKey::generate(kind);
    const auto pem = *key.to_pem();
    const auto path =
        pem.expose([&](BytesView octets) { return folder_->write(name, as_text(octets)); });
    run(with_pin_option("softhsm2-util --import " + path + " --token robot --label " + name +
                        " --id 0" + std::to_string(++imported_)));
  }
  static std::string uri(std::string_view object, std::string_view more = "") {
    return "pkcs11:token=robot;object=" + std::string(object) + std::string(more);
  }
  static std::string with_pin(std::string_view object) {
    return uri(object, "?pin-value=open%20sesame%201");
  }
  static Passphrase pin(std::string_view text = kPin) {
    return *Passphrase::copy_of(as_bytes(text));
  }
  static Result<PrivateKey> key(std::string_view object) {
    return PrivateKey::load(with_pin(object), kProperty);
  }

  static inline std::unique_ptr<test::TemporaryFolder> folder_;
  static inline int imported_ = 0;
};

// This must run before another test logs in, because a login lasts as long as the process.
TEST_F(Pkcs11Token, MissingOrWrongPin_IsRefused) {
  const auto missing = PrivateKey::load(uri("ec"), kProperty);
  EXPECT_CODE(missing, pkcs11_pin_missing);
  EXPECT_EQ(missing.error().details().document, kProperty);
  const auto wrong = pin("4711");
  EXPECT_CODE(PrivateKey::load(uri("ec"), kProperty, &wrong), pkcs11_pin_wrong);
  const auto refused = PrivateKey::load(uri("ec", ";pin-value=4712"), kProperty);
  EXPECT_CODE(refused, pkcs11_pin_wrong);
  EXPECT_EQ(refused.error().to_sentence().find("4712"), std::string::npos);
  const auto right = pin();
  ASSERT_OK(PrivateKey::load(uri("ec"), kProperty, &right));
}

TEST_F(Pkcs11Token, ForbiddenLogin_IsNotTried) {
  const auto right = pin();
  {
    const LoginBan forbidden(true);
    EXPECT_CODE(PrivateKey::load(uri("ec"), kProperty, &right), pkcs11_not_tried);
    const LoginBan of_another_folder(false);
    EXPECT_CODE(PrivateKey::load(uri("ec"), kProperty, &right), pkcs11_not_tried);
  }
  const LoginBan allowed(false);
  ASSERT_OK(PrivateKey::load(uri("ec"), kProperty, &right));
}

TEST_F(Pkcs11Token, AnAttributeThatIsGivenTwice_IsRefused) {
  const auto path = folder_->write("one pin", kPin);
  const auto source = "pin-source=" + folder_->path() + "/one%20pin";
  for (const auto& more : {"?" + source + "&" + source, ";" + source + "?" + source,
                           ";object=rsa?" + source, "?" + source + "&pin-value=1&pin-value=2"}) {
    const auto refused = PrivateKey::load(uri("ec", more), kProperty);
    ASSERT_FALSE(refused) << more;
    EXPECT_EQ(refused.error().code(), Code::pkcs11_not_found);
    EXPECT_NE(refused.error().to_sentence().find("given twice"), std::string::npos);
  }
}

TEST_F(Pkcs11Token, ThePin_MayLieInAFileWithALineEnd) {
  const auto path = folder_->write("pin of robot", std::string(kPin) + "\r\n");
  const auto escaped = folder_->path() + "/pin%20of%20robot";
  for (const auto& source : {escaped, "file:" + escaped, "file://" + escaped})
    ASSERT_OK(PrivateKey::load(uri("ec", "?pin-source=" + source), kProperty));
  EXPECT_CODE(PrivateKey::load(uri("ec", "?pin-source=" + path + ".not"), kProperty),
              file_not_found);
  for (const auto* broken : {"%2", "%zz", "%"})
    EXPECT_CODE(PrivateKey::load(uri("ec", "?pin-source=" + path + broken), kProperty),
                pkcs11_not_found);
}

TEST_F(Pkcs11Token, WhatIsNotThere_IsNamedWithoutThePin) {
  for (const auto& gone :
       {with_pin("nobody"), std::string("pkcs11:token=other;object=ec?pin-value=x"),
        std::string("pkcs11:rubbish"), std::string("pkcs11:"),
        std::string("pkcs11:token=robot;slot-id=1?pin-value=x")}) {
    const auto loaded = PrivateKey::load(gone, kProperty);
    EXPECT_CODE(loaded, pkcs11_not_found);
    EXPECT_EQ(loaded.error().to_sentence().find("pin-value"), std::string::npos);
    EXPECT_CODE(load_certificates(gone, kProperty, kMaxBundleOctets), pkcs11_not_found);
  }
}

TEST_F(Pkcs11Token, HeldKey_SignsAsAKeyInAFileDoes) {
  for (const auto* name : {"ec", "p384", "rsa"}) {
    const auto held = key(name);
    ASSERT_OK(held);
    const auto in_file = *PrivateKey::load("file:" + folder_->path() + "/" + name, kProperty);
    EXPECT_EQ(held->algorithm(), in_file.algorithm());
    const auto ca = make_ca();
    const auto certificate =
        ca.certify({.subject = "CN=robot", .validity = kYear}, *held, test_random());
    ASSERT_OK(certificate);
    ASSERT_OK(held->check_fits(*certificate));
    ASSERT_OK(in_file.check_fits(*certificate));
    const auto message = as_bytes("message");
    const auto signature = sign(*held, message);
    ASSERT_OK(signature);
    ASSERT_OK(verify(*certificate, message, *signature));
    const auto request = make_request(*held, "CN=robot");
    ASSERT_OK(request);
    EXPECT_EQ(read_request(as_bytes(*request))->key, held->algorithm());
    EXPECT_CODE(held->to_pem(), key_in_token);
  }
}

TEST_F(Pkcs11Token, CaInAToken_SignsAndIssues) {
  for (const auto* name : {"ec", "rsa"}) {
    const auto ca = Authority::create_root("CN=CA in a token", *key(name), kYear, test_random());
    ASSERT_OK(ca);
    const auto issued = ca->issue("CN=talker", {}, kYear, test_random());
    ASSERT_OK(issued);
    ASSERT_OK(ChainVerifier::make({ca->certificate()}, {})->verify(issued->certificate, kNow));
    const auto document = ca->sign_document(as_bytes("<dds/>\n"), kNow, test_random());
    ASSERT_OK(document);
    ASSERT_OK(DocumentVerifier::make({ca->certificate()})->verify(*document, kNow));
    ASSERT_OK(ca->make_crl({.this_update = kNow, .next_update = kYear.not_after}));
  }
}

TEST_F(Pkcs11Token, HeldCertificates_AreRead) {
  const auto ca = make_ca();
  const auto path = folder_->write("ca.pem", ca.certificate().pem());
  run(with_pin_option(
      "pkcs11-tool --module \"$(find /usr/lib -name libsofthsm2.so | head -n 1)\" --token-label "
      "robot --write-object " +
      path + " --type cert --label ca --login"));
  const auto pem = load_certificates(uri("ca", ";type=cert"), "", kMaxBundleOctets);
  ASSERT_OK(pem);
  EXPECT_EQ(*Certificate::from_pem(*pem), ca.certificate());
}

TEST(KeysByUri, FileOfTheirOwn_NamesThemToo) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(uri_of("a/key.pem"), "file://a/key.pem");
  EXPECT_EQ(uri_of(folder.write("key.p11", "pkcs11:object=a\nmore\n")), "pkcs11:object=a");
  EXPECT_CODE(uri_of(folder.write("b.p11", "file:/key.pem\n")), unsupported_uri);
  EXPECT_CODE(uri_of(folder.write("c.p11", "")), item_empty);
  EXPECT_CODE(uri_of(folder.path() + "/d.p11"), file_not_found);
}

TEST(KeysByUri, ShownUri_HasNoPin) {
  for (const auto* text : {"pkcs11:object=a?pin-value=1234", "  pkcs11:object=a;pin-value=1234",
                           "pkcs11:object=a;pin-source=file:/1234", "pkcs11:object=a"}) {
    EXPECT_TRUE(names_token(text));
    EXPECT_EQ(without_pin(text), "pkcs11:object=a");
  }
  EXPECT_EQ(without_pin("pkcs11:pin-value=1234;object=a"), "pkcs11:object=a");
  EXPECT_LE(without_pin("pkcs11:object=" + std::string(5000, 'a')).size(), 300u);
  EXPECT_FALSE(names_token("file:pkcs11:"));
}

}  // namespace
}  // namespace ddssec::pki
