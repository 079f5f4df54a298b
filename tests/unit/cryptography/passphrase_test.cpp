// Files of passphrases: what is read, and what is refused without repeating it in the error.
#include "plugins/cryptography/passphrase.hpp"

#include <sys/stat.h>

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/cryptography/passphrases.hpp"

namespace ddssec::cryptography::testing {
namespace {

Result<std::vector<Passphrase>> load(const PropertyList& properties) {
  test::RecordedEvents events;
  return PassphraseFiles(properties, {}).load(events);
}
std::string text_of(const Passphrase& passphrase) {
  return passphrase.text.expose([](BytesView octets) { return std::string(as_text(octets)); });
}

TEST(Passphrases, LinesWithIds_AreRead) {
  const auto all = load(
      passphrase("5612:Open: Sesame~\r\n", "0:a\n4294967294:b\r\n\r\n7:c d\r5612:Open: Sesame~\n"));
  ASSERT_TRUE(all) << all.error().to_sentence();
  ASSERT_EQ(all->size(), 4u);
  EXPECT_EQ((*all)[0].id, 5612u);
  EXPECT_EQ(text_of((*all)[0]), "Open: Sesame~");
  EXPECT_EQ((*all)[1].id, 0u);
  EXPECT_EQ((*all)[2].id, 4294967294u);
  EXPECT_EQ(text_of((*all)[3]), "c d");
  EXPECT_TRUE(load(passphrase("1:" + std::string(512, '!'))));
}

TEST(Passphrases, WhatIsWrong_IsNamedAndNotRepeated) {
  const std::string secret = "xyzzy";
  const auto refused = [&](const PropertyList& properties) {
    const auto all = load(properties);
    ASSERT_FALSE(all);
    EXPECT_EQ(all.error().code(), Code::invalid_property) << all.error().to_sentence();
    EXPECT_EQ(all.error().to_sentence().find(secret), std::string::npos);
    EXPECT_NE(all.error().to_sentence().find("rtps_psk_secret_passphrase"), std::string::npos);
  };
  for (const auto& line : {secret,
                           ":" + secret,
                           "x:" + secret,
                           "-1:" + secret,
                           " 1:" + secret,
                           "1 :" + secret,
                           "0x1:" + secret,
                           "4294967296:" + secret,
                           "255:" + secret,
                           "4294967295:" + secret,
                           "511:" + secret,
                           std::string("1:"),
                           "1: " + secret,
                           "1:" + secret + " ",
                           "1:" + secret + "\t",
                           "1:" + secret + "\x7f",
                           "1:" + secret + "\xc3\xa4",
                           "1:" + secret + std::string(508, 'x'),
                           "1:" + secret + "\n2:" + secret,
                           std::string("\n")})
    refused(passphrase(line));
  refused(passphrase("1:" + secret, "2:" + secret + "\n1:another"));
  refused(passphrase("1:" + secret, secret));
  std::string many;
  for (int id = 2; id < 18; ++id) many += std::to_string(id) + ":" + secret + "\n";
  refused(passphrase("1:" + secret, many));
  const auto pasted = load({{std::string(property::kPskPassphrase), "1:" + secret}});
  EXPECT_EQ(code_of(pasted), Code::unsupported_uri);
  EXPECT_EQ(pasted.error().to_sentence().find(secret), std::string::npos);
}

TEST(Passphrases, AFileThatOthersMayRead_IsNotPassedOverInSilence) {
  const test::TemporaryFolder folder;
  const auto path = folder.write("psk", "5612:Open Sesame\n");
  const PropertyList properties = {{std::string(property::kPskPassphrase), "file:" + path}};
  const auto events_with = [&](::mode_t mode) {
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
    test::RecordedEvents events;
    const auto all = PassphraseFiles(properties, {}).load(events);
    EXPECT_TRUE(all && text_of(all->front()) == "Open Sesame");
    return events.codes();
  };
  EXPECT_EQ(events_with(0600), std::vector<Code>{});
  EXPECT_EQ(events_with(0640), std::vector{Code::psk_passphrase_exposed});
  std::filesystem::remove(path);
  EXPECT_EQ(code_of(load(properties)), Code::file_not_found);
}

TEST(ChangedPassphrases, RelativePaths_NameTheSameFilesAfterChdir) {
  const test::TemporaryFolder folder, elsewhere;
  const test::WorkingFolder at(folder.path());
  for (const auto* one : {&folder, &elsewhere})
    ::chmod(one->write("own", one == &folder ? "1:ours" : "1:theirs").c_str(), 0600);
  PassphraseFiles files({{std::string(property::kPskPassphrase), "file:own"}},
                        std::chrono::seconds(1));
  const test::WorkingFolder there(elsewhere.path());
  test::RecordedEvents events;
  const auto all = files.load(events);
  ASSERT_TRUE(all) << all.error().to_sentence();
  EXPECT_EQ(text_of(all->front()), "ours");
  EXPECT_EQ(files.place_of(property::kPskPassphrase), folder.path() + "/own");
}

}  // namespace
}  // namespace ddssec::cryptography::testing
