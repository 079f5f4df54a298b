#include "plugins/authentication/token_fields.hpp"

#include "plugins/authentication/auth_request.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(TokenClass, NameAndMajorVersion_Count) {
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0"), TokenClass::identity);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.2"), TokenClass::identity);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+Req"), TokenClass::request);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.2+Reply"), TokenClass::reply);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+Final"), TokenClass::final);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+AuthReq"), TokenClass::auth_request);
  for (const auto id :
       {"", "DDS:Auth:PKI-DH", "DDS:Auth:PKI-DH:1.", "DDS:Auth:PKI-DH:2.0", "DDS:Auth:PKI-DH:1.0+",
        "DDS:Auth:PKI-DH:1.0+request", "DDS:Auth:PKI-DH:1.0 ", "dds:Auth:PKI-DH:1.0",
        "DDS:Auth:PKI-DH:1.0000000000", "DDS:Auth:PKI-DH:10.0"})
    EXPECT_FALSE(token_class_of(id)) << id;
}

TEST(TokenFields, UnknownFieldsWithinBounds_AreTolerated) {
  Token token = sample();
  token.binary_properties.push_back({"com.example.new", Bytes(kMaxUnknownOctets)});
  token.properties.push_back({"note", std::string(kMaxTextOctets, 'x')});
  EXPECT_TRUE(read_auth_request(token));
}

TEST(TokenFields, TooManyUnknownOctets_AreRefused) {
  Token unknown = sample();
  unknown.binary_properties.push_back({"x", Bytes(kMaxUnknownOctets + 1)});
  EXPECT_CODE(read_auth_request(unknown), token_too_large);
  Token name = sample();
  name.binary_properties.push_back({std::string(kMaxTextOctets + 1, 'x'), {}});
  EXPECT_CODE(read_auth_request(name), token_too_large);
  Token text = sample();
  text.properties.push_back({"x", std::string(kMaxTextOctets + 1, 'x')});
  EXPECT_CODE(read_auth_request(text), token_too_large);
  Token many = sample();
  for (std::size_t i = 0; i < spi::kMaxPropertiesPerToken; ++i)
    many.binary_properties.push_back({std::to_string(i), {}});
  EXPECT_CODE(read_auth_request(many), token_too_large);
  Token ocsp = sample();
  ocsp.binary_properties.push_back({"ocsp_status", Bytes(kMaxUnknownOctets + 1)});
  EXPECT_CODE(read_auth_request(ocsp), token_too_large);
}

}  // namespace
}  // namespace ddssec::authentication
