// What a URI of a property names, and what errors say about it.
#include "base/uri_source.hpp"

#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include "base/secret.hpp"
#include "tests/support/expect_code.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

constexpr std::string_view kProperty = "dds.sec.auth.identity_ca";
using KeyPem = Secret<struct KeyPemTag, 16 * 1024>;

Bytes bytes(std::string_view text) { return to_bytes(as_bytes(text)); }

class UriSource : public testing::Test {
 protected:
  UriSource() {
    folder_ =
        std::filesystem::temp_directory_path() / ("ddssec-source-" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder_);
  }
  ~UriSource() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, std::string_view text) const {
    const auto path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  std::filesystem::path folder_;
};

TEST_F(UriSource, FilesAndTexts_AreRead) {
  const auto path = write("a", "hello");
  for (const auto& uri : {"file:" + path, "file://" + path, "  \t file:" + path})
    EXPECT_EQ(load_uri(uri, kProperty, 10), bytes("hello")) << uri;
  EXPECT_EQ(load_uri("data:,a%20b\n", kProperty, 10), bytes("a%20b\n"));
  EXPECT_EQ(load_uri(" data:,x", kProperty, 1), bytes("x"));
  const auto key = load_secret<KeyPem>("file:" + path, kProperty);
  ASSERT_TRUE(key);
  EXPECT_TRUE(key->expose([](BytesView octets) { return as_text(octets) == "hello"; }));
  EXPECT_EQ(load_secret<KeyPem>("data:,abc", kProperty)->size(), 3u);
}

TEST_F(UriSource, EachRefusal_HasItsCodeAndNamesTheProperty) {
  const auto path = write("a", "hello");
  const auto empty = write("empty", "");
  const auto large = write("large", std::string(20000, 'x'));
  const auto check = [](const std::string& uri, Code code, std::size_t most = 16 * 1024) {
    const auto item = load_uri(uri, kProperty, most);
    const auto key = load_secret<KeyPem>(uri, kProperty);
    ASSERT_FALSE(item);
    EXPECT_EQ(item.error().code(), code) << item.error().to_sentence();
    EXPECT_EQ(item.error().details().document, kProperty);
    ASSERT_FALSE(key);
    EXPECT_EQ(key.error().code(), code) << key.error().to_sentence();
  };
  check("", Code::missing_property);
  check("   ", Code::missing_property);
  check("file:" + path + ".not", Code::file_not_found);
  check("file:" + path + "/below", Code::file_not_found);
  check("file:" + folder_.string(), Code::file_unreadable);
  check("file:" + empty, Code::item_empty);
  check("data:,", Code::item_empty);
  check("file:" + large, Code::file_too_large);
  check("data:," + std::string(20000, 'x'), Code::file_too_large);
  check("pkcs11:object=key", Code::pkcs11_unsupported);
  check(path, Code::unsupported_uri);
  check("FILE:" + path, Code::unsupported_uri);
  check("http://example.org/", Code::unsupported_uri);
  check("data:text/plain;base64,aGVsbG8=", Code::unsupported_uri);
}

TEST(TooManyOctets, Error_NamesTheLimitAndTheSize) {
  const auto error = too_many_octets_error(Code::crl_too_large, 10, 11);
  EXPECT_EQ(error.code(), Code::crl_too_large);
  EXPECT_EQ(error.details().expected, "at most 10 octets");
  EXPECT_EQ(error.details().found, "11");
}

TEST_F(UriSource, Fifo_IsRefused) {
  const auto path = (folder_ / "fifo").string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_CODE(load_uri("file:" + path, kProperty, 10), file_unreadable);
}

TEST_F(UriSource, APastedKey_DoesNotReachTheError) {
  const auto item = load_secret<KeyPem>("-----BEGIN PRIVATE KEY-----\nMIGHAgEAMBMG", kProperty);
  EXPECT_CODE(item, unsupported_uri);
  EXPECT_EQ(item.error().to_sentence().find("MIGH"), std::string::npos);
}

TEST_F(UriSource, FileReadableByOthers_IsKnown) {
  const auto path = write("key", "hello");
  const auto after = [&](::mode_t mode) {
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    return readable_by_others("file:" + path);
  };
  EXPECT_FALSE(after(0600));
  EXPECT_FALSE(after(0611));
  EXPECT_TRUE(after(0640));
  EXPECT_TRUE(after(0604));
  EXPECT_FALSE(readable_by_others("file:" + path + ".not"));
  EXPECT_FALSE(readable_by_others("data:," + path));
}

TEST(TokenUri, PinAndQuery_AreNotShown) {
  EXPECT_TRUE(names_token(" pkcs11:object=key"));
  EXPECT_FALSE(names_token("PKCS11:object=key"));
  EXPECT_EQ(without_pin("pkcs11:object=key?pin-value=1234"), "pkcs11:object=key");
  EXPECT_EQ(without_pin("pkcs11:object=key;pin-value=1234;id=1"), "pkcs11:object=key;id=1");
  EXPECT_EQ(without_pin("pkcs11:pin-value=1234;object=key"), "pkcs11:object=key");
  EXPECT_EQ(without_pin("pkcs11:object=" + std::string(1000, 'x')).size(), 256u);
  EXPECT_EQ(without_pin("file:/1234"), "");
}

TEST(TokenUri, MisspeltPin_IsNotShown) {
  for (const auto* pin : {";PIN-VALUE=1234", "&pin-value=1234", "?pin_value=1234", ";pn-value=1234",
                          ";1234", ";pin-value 1234", ";=1234", ";;pin=1234&", "?=1234"})
    EXPECT_EQ(without_pin(std::string("pkcs11:token=t;object=key") + pin),
              "pkcs11:token=t;object=key")
        << pin;
  EXPECT_EQ(without_pin("pkcs11:object=key,pin-value=1234"), "pkcs11:object=key,pin-value");
}

TEST(FileUri, OtherUris_NameNoFile) {
  EXPECT_EQ(file_named_by("file:a/b"), "a/b");
  EXPECT_EQ(file_named_by(" file:///a"), "/a");
  for (const char* const other : {"", "data:,x", "pkcs11:object=key", "a/b"})
    EXPECT_EQ(file_named_by(other), std::nullopt) << other;
}

TEST(FileUri, RelativePath_BecomesAbsolute) {
  const test::TemporaryFolder folder;
  const test::WorkingFolder here(folder.path());
  EXPECT_EQ(absolute_uri("file:a"), "file:" + folder.path() + "/a");
  for (const char* const same : {"file:/a", "file:///a", "file:", "data:,a", "pkcs11:object=a"})
    EXPECT_EQ(absolute_uri(same), same);
}

TEST(FileUri, RelativeUriWithoutAWorkingFolder_NamesNothing) {
  const test::TemporaryFolder folder;
  const auto gone = folder.path() + "/gone";
  std::filesystem::create_directory(gone);
  const test::WorkingFolder here(gone);
  std::filesystem::remove(gone);
  EXPECT_EQ(absolute_uri("file:a"), "");
  EXPECT_EQ(absolute_uri("file:/a"), "file:/a");
}

}  // namespace
}  // namespace ddssec
