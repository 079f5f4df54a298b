// Certificates and keys, named by a path or a URI.
#include "pki/certificate_source.hpp"

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

TEST(UriOf, Path_IsAFileUnlessItNamesAKeyInAToken) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(uri_of("/a/key.pem"), "file:///a/key.pem");
  EXPECT_EQ(uri_of(folder.write("key.p11", "pkcs11:object=key\r\nmore\n")), "pkcs11:object=key");
  EXPECT_EQ(uri_of(folder.write("bare.p11", "pkcs11:object=key")), "pkcs11:object=key");
}

TEST(UriOf, FileForATokenWithoutAUri_IsRefused) {
  const test::TemporaryFolder folder;
  for (const char* const text : {"file:key.pem\n", "\npkcs11:object=key\n", "nonsense"}) {
    const auto path = folder.write("key.p11", text);
    const auto refused = uri_of(path);
    EXPECT_CODE(refused, unsupported_uri);
    EXPECT_EQ(refused.error().details().document, path);
  }
  EXPECT_CODE(uri_of(folder.path() + "/none.p11"), file_not_found);
  EXPECT_CODE(uri_of(folder.write("long.p11", std::string(4097, 'x'))), file_too_large);
}

TEST(AboutFile, Error_NamesThePathOnce) {
  const Error error(Code::file_unreadable, {.document = "property", .found = "/a", .note = "why"});
  const auto about = file_error(error, "/a");
  EXPECT_EQ(about.code(), Code::file_unreadable);
  EXPECT_EQ(about.details().document, "/a");
  EXPECT_EQ(about.details().found, "");
  EXPECT_EQ(about.details().note, "why");
  EXPECT_EQ(file_error(error, "/b").details().found, "/a");
}

TEST(LoadCertificates, FileThatTheUriNames_IsReadAsItIs) {
  const test::TemporaryFolder folder;
  const auto pem = make_ca().certificate().pem();
  const auto path = folder.write("ca.pem", pem);
  EXPECT_EQ(load_certificates("file:" + path, "property", 10'000), bytes(pem));
  EXPECT_CODE(load_certificates("file:" + path, "property", 10), file_too_large);
}

}  // namespace
}  // namespace ddssec::pki
