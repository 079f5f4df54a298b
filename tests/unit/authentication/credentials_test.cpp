// Credentials as they are read, and their hash against the vectors of the reference.
#include "plugins/authentication/credentials.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

Credentials vector_a() {
  static const Bytes id = bytes("-----BEGIN"), permissions = bytes("P"), data = {0, 1, 0, 0},
                     signature = bytes("ECDSA-SHA256"), agreement = bytes("ECDH+prime256v1-CEUM");
  return {id, permissions, data, signature, agreement, {}};
}

Result<Credentials> read(const Token& token) {
  return Credentials::read(TokenFields::of(token, TokenClass::request).value());
}

Token request_with(const Credentials& credentials) {
  Token token{.class_id = "DDS:Auth:PKI-DH:1.0+Req"};
  credentials.write(token);
  return token;
}

TEST(CredentialsFields, AsWritten_ComeBack) {
  const auto token = request_with(vector_a());
  const auto back = read(token);
  ASSERT_OK(back);
  EXPECT_EQ(back->hash(), vector_a().hash());
}

TEST(CredentialsFields, UnknownAlgorithm_IsRefusedByItsName) {
  const auto token = request_with(vector_a());
  const auto signature = with(token, "c.dsign_algo", bytes("ECDSA-SHA255"));
  EXPECT_CODE(read(signature), signature_algorithm_unknown);
  const auto agreement = with(token, "c.kagree_algo", bytes("ECDH+prime256v0-CEUM"));
  EXPECT_CODE(read(agreement), key_agreement_algorithm_unknown);
}

TEST(CredentialsFields, Missing_AreRefused) {
  const auto token = request_with(vector_a());
  for (const auto* name : {"c.id", "c.pdata", "c.dsign_algo", "c.kagree_algo"})
    EXPECT_CODE(read(without(token, name)), token_field_missing);
  EXPECT_TRUE(read(without(token, "c.perm"))) << "it is optional";
}

TEST(Hashes, KnownInput_GivesTheReferenceValue) {
  EXPECT_EQ(to_hex(vector_a().hash()),
            "f436fdded2a5dbcbf37a027eb2f6cc06eb9c4aeefdc47b9cdfd47847fd3222d7");
}

TEST(Hashes, AbsentPermissions_AreNotEmptyPermissions) {
  auto absent = vector_a();
  absent.permissions.reset();
  auto empty = vector_a();
  empty.permissions = BytesView();
  EXPECT_NE(absent.hash(), empty.hash());
}

}  // namespace
}  // namespace ddssec::authentication
