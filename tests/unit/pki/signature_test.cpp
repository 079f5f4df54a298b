// Signatures of handshake messages.
#include "pki/signature.hpp"

#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

struct Signer {
  explicit Signer(KeySpec key) : credential(make_leaf(make_ca(), "CN=signer", key)) {}
  Bytes sign(std::string_view text) const { return pki::sign(credential.key, bytes(text)).value(); }
  Status verify(std::string_view text, const Bytes& signature) const {
    const auto valid = pki::verify(credential.certificate, bytes(text), signature);
    if (!valid) return std::unexpected(valid.error());
    EXPECT_EQ(valid->signer(), credential.certificate);
    return {};
  }
  Credential credential;
};

class Signature : public testing::TestWithParam<KeySpec> {};
INSTANTIATE_TEST_SUITE_P(EveryKind, Signature,
                         testing::Values(KeySpec{KeyKind::ec_p256}, KeySpec{KeyKind::ec_p384},
                                         KeySpec{KeyKind::rsa, 2048}));

TEST_P(Signature, AnotherMessage_IsRefused) {
  const Signer signer(GetParam());
  const auto signature = signer.sign("message");
  EXPECT_TRUE(signer.verify("message", signature));
  EXPECT_CODE(signer.verify("messagf", signature), signature_invalid);
  EXPECT_CODE(signer.verify("message ", signature), signature_invalid);
  EXPECT_CODE(signer.verify("", signature), signature_invalid);
}

TEST_P(Signature, AnotherKey_IsInvalid) {
  const Signer signer(GetParam()), other(KeySpec{KeyKind::ec_p256});
  EXPECT_CODE(other.verify("message", signer.sign("message")), signature_invalid);
  EXPECT_CODE(signer.verify("message", other.sign("message")), signature_invalid);
}

TEST_P(Signature, EachChangedOctetAndEachTruncation_MakesItInvalid) {
  const Signer signer(GetParam());
  const auto signature = signer.sign("message");
  for (std::size_t i = 0; i < signature.size(); i += 5) {
    auto changed = signature;
    changed[i] ^= 1;
    EXPECT_CODE(signer.verify("message", changed), signature_invalid);
    const Bytes cut(signature.begin(), signature.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_CODE(signer.verify("message", cut), signature_invalid);
  }
  auto longer = signature;
  longer.push_back(0);
  EXPECT_CODE(signer.verify("message", longer), signature_invalid);
}

TEST(SignatureLimit, LongerThanAnyKeyMakes_IsNotEvenVerified) {
  const Signer signer(KeySpec{KeyKind::ec_p256});
  const auto refused = signer.verify("message", Bytes(kMaxSignatureOctets + 1));
  EXPECT_CODE(refused, signature_invalid);
  EXPECT_EQ(refused.error().details().note, "it is too long");
}

}  // namespace
}  // namespace ddssec::pki
