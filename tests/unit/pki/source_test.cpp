#include "pki/source.hpp"

#include <filesystem>
#include <sys/stat.h>
#include <unistd.h>

#include "fixture.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kProperty = "dds.sec.auth.identity_ca";

class Source : public testing::Test {
 protected:
  Source() {
    folder_ =
        std::filesystem::temp_directory_path() / ("ddssec-source-" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder_);
  }
  ~Source() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, std::string_view text) const {
    const auto path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  std::filesystem::path folder_;
};

TEST_F(Source, ReadsFilesAndTexts) {
  const auto path = write("a", "hello");
  for (const auto& uri : {"file:" + path, "file://" + path, "  \t file:" + path})
    EXPECT_EQ(load(uri, kProperty, 10), bytes("hello")) << uri;
  EXPECT_EQ(load("data:,a%20b\n", kProperty, 10), bytes("a%20b\n"));
  EXPECT_EQ(load(" data:,x", kProperty, 1), bytes("x"));
  const auto key = load_secret<KeyPem>("file:" + path, kProperty);
  ASSERT_TRUE(key);
  EXPECT_TRUE(key->expose([](BytesView octets) { return as_text(octets) == "hello"; }));
  EXPECT_EQ(load_secret<KeyPem>("data:,abc", kProperty)->size(), 3u);
}

TEST_F(Source, EachRefusalHasItsCodeAndNamesTheProperty) {
  const auto path = write("a", "hello");
  const auto empty = write("empty", "");
  const auto large = write("large", std::string(20000, 'x'));
  const auto check = [](const std::string& uri, Code code, std::size_t most = 16 * 1024) {
    const auto item = load(uri, kProperty, most);
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

TEST_F(Source, AFifoDoesNotHang) {
  const auto path = (folder_ / "fifo").string();
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_CODE(load("file:" + path, kProperty, 10), file_unreadable);
}

TEST_F(Source, APastedKeyDoesNotReachTheError) {
  const auto item = load_secret<KeyPem>("-----BEGIN PRIVATE KEY-----\nMIGHAgEAMBMG", kProperty);
  EXPECT_CODE(item, unsupported_uri);
  EXPECT_EQ(item.error().to_sentence().find("MIGH"), std::string::npos);
}

TEST_F(Source, KnowsWhoElseMayReadAFile) {
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

}  // namespace
}  // namespace ddssec::pki
