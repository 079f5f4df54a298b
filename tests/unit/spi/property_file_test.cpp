#include "plugins/spi/property_file.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

TEST(PropertyFile, NamesAndValues_AreRead) {
  const PropertyList expected = {{std::string(property::kPassword), "c = d", false},
                                 {std::string(property::kKeySize), "", false},
                                 {std::string(property::kCrl), "g", false}};
  const std::string text =
      "# comment\r\n\n  dds.sec.auth.password=c = d \r\ndds.sec.crypto.keysize =\n"
      "\torg.eclipse.cyclonedds.sec.auth.crl\t=\tg";
  EXPECT_EQ(parse_properties(text).value(), expected);
  EXPECT_EQ(parse_properties("\xef\xbb\xbf" + text).value(), expected) << "a byte order mark";
  EXPECT_TRUE(parse_properties("").value().empty());
}

TEST(PropertyFile, RefusedLine_IsNamed) {
  const std::string name(property::kPassword);
  const std::pair<std::string, int> bad[] = {{name + "=b\nc", 2},
                                             {"= b", 1},
                                             {name + " = b\n\n# x\n" + name + " = c", 4},
                                             {name + " = b\x01"
                                                     "c",
                                              1},
                                             {name + "\x7f=", 1}};
  for (const auto& [text, line] : bad) {
    const auto parsed = parse_properties(text);
    ASSERT_FALSE(parsed) << line;
    EXPECT_EQ(parsed.error().code(), Code::invalid_property);
    EXPECT_EQ(parsed.error().details().line, line);
  }
}

// A mistyped name would have no effect, and no other check would find it.
TEST(PropertyFile, AnUnknownName_IsRefusedWithTheOneThatWasMeant) {
  const std::pair<std::string, std::string_view> unknown[] = {
      {"org.ddssec.files_poll_intervall", property::kFilesPollInterval},
      {"org.ddssec.auth.later_crll", property::kLaterCrl},
      {"org.eclipse.cyclonedds.sec.auth.cr", property::kCrl},
      {"ORG.DDSSEC.FILES_POLL_INTERVAL", property::kFilesPollInterval},
      {"dds.sec.auth.Password", property::kPassword},
      {"mine", ""},
      {std::string(60'000, 'x'), ""},
      {std::string(property::kAnnouncedCiphers), ""}};
  for (const auto& [name, meant] : unknown) {
    const auto parsed = parse_properties("# first\n" + name + " = 1\n");
    ASSERT_FALSE(parsed) << name;
    EXPECT_EQ(parsed.error().code(), Code::property_unknown);
    const auto& details = parsed.error().details();
    EXPECT_EQ(details.line, 2);
    EXPECT_EQ(details.expected, meant);
    const bool looks_like_one = !meant.empty() || name == property::kAnnouncedCiphers;
    EXPECT_EQ(details.found, looks_like_one ? name.substr(0, 64) : "another name");
  }
}

// The path may be a link to any file that the process may read, so its content must not get into an
// error.
TEST(PropertyFile, WhatIsNoFileOfProperties_IsNotQuoted) {
  for (const std::string text :
       {"hunter2\n", "root:$6$hunter2:1:2\n", "hunter2==\n", "hunter2 = 1\n", "TOKEN=hunter2\n",
        "hunter2\x01 = 1\n", "dds.sec.auth.password=hunter2\x01\n", "=hunter2\n",
        "-----BEGIN hunter2-----\n"}) {
    const auto parsed = parse_properties(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().to_sentence().find("hunter2"), std::string::npos)
        << parsed.error().to_sentence();
  }
}

TEST(PropertyFile, EveryNameThatConfiguresAParticipant_IsKnown) {
  for (const auto name : property::kOfParticipants)
    EXPECT_EQ(parse_properties(std::string(name) + " = x").value().front().name, name);
}

TEST(PropertyFile, MissingUnreadableOrLargeFile_IsRefused) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "ddssec-property-file";
  std::filesystem::create_directories(folder);
  const auto file = folder / "security.properties";
  const auto write = [&](std::string_view text) { std::ofstream(file, std::ios::binary) << text; };
  write("dds.sec.auth.password = b");
  EXPECT_EQ(read_property_file(file)->front().value, "b");
  write("nonsense");
  const auto refused = read_property_file(file);
  EXPECT_EQ(refused.error().code(), Code::invalid_property);
  EXPECT_EQ(refused.error().details().document, file.string());
  write("#" + std::string(kMaxPropertyFileOctets - 1, 'x'));
  EXPECT_TRUE(read_property_file(file));
  write("#" + std::string(kMaxPropertyFileOctets, 'x'));
  EXPECT_EQ(read_property_file(file).error().code(), Code::file_too_large);
  EXPECT_EQ(read_property_file(folder / "other").error().code(), Code::file_not_found);
  EXPECT_EQ(read_property_file(folder).error().code(), Code::file_unreadable);
}

}  // namespace
}  // namespace ddssec::spi
