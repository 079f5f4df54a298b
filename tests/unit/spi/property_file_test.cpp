#include "plugins/spi/property_file.hpp"

#include <fstream>

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

TEST(PropertyFile, ReadsNamesAndValues) {
  const PropertyList expected = {{"a.b", "c = d", false}, {"e", "", false}, {"f", "g", false}};
  EXPECT_EQ(parse_properties("# comment\r\n\n  a.b=c = d \r\ne =\n\tf\t=\tg").value(), expected);
  EXPECT_TRUE(parse_properties("").value().empty());
}

TEST(PropertyFile, NamesTheLineItRefuses) {
  std::string many;
  for (std::size_t i = 0; i <= kMostPropertiesPerFile; ++i) many += "p" + std::to_string(i) + "=\n";
  const std::pair<std::string, int> bad[] = {{"a=b\nc", 2},
                                             {"= b", 1},
                                             {"a = b\n\n# x\na = c", 4},
                                             {"a = b\x01"
                                              "c",
                                              1},
                                             {"a\x7f=", 1},
                                             {many, static_cast<int>(kMostPropertiesPerFile) + 1}};
  for (const auto& [text, line] : bad) {
    const auto parsed = parse_properties(text);
    ASSERT_FALSE(parsed) << line;
    EXPECT_EQ(parsed.error().code(), Code::invalid_property);
    EXPECT_EQ(parsed.error().details().line, line);
  }
}

TEST(PropertyFile, IsThereReadableAndSmall) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "ddssec-property-file";
  std::filesystem::create_directories(folder);
  const auto file = folder / "security.properties";
  const auto write = [&](std::string_view text) { std::ofstream(file, std::ios::binary) << text; };
  write("a = b");
  EXPECT_EQ(read_property_file(file)->front().value, "b");
  write("nonsense");
  const auto refused = read_property_file(file);
  EXPECT_EQ(refused.error().code(), Code::invalid_property);
  EXPECT_EQ(refused.error().details().document, file.string());
  write("#" + std::string(kMostPropertyFileOctets - 1, 'x'));
  EXPECT_TRUE(read_property_file(file));
  write("#" + std::string(kMostPropertyFileOctets, 'x'));
  EXPECT_EQ(read_property_file(file).error().code(), Code::file_too_large);
  EXPECT_EQ(read_property_file(folder / "other").error().code(), Code::file_not_found);
  EXPECT_EQ(read_property_file(folder).error().code(), Code::file_unreadable);
}

}  // namespace
}  // namespace ddssec::spi
