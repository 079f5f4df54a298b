// What is read from XML that passes the check.
#include "governance/xml.hpp"

#include <filesystem>

#include "tests/support/test_data.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

Result<XmlDocument> parse(std::string_view text) { return XmlDocument::parse(as_bytes(text)); }

TEST(XmlText, OnePiece_IsReadWithoutBlanksAround) {
  for (const auto* text : {"<a>  x&amp; &lt;z&gt;\n</a>", "<a><![CDATA[x& <z>]]></a>"}) {
    const auto document = parse(text);
    ASSERT_TRUE(document);
    EXPECT_EQ(document->root().text(), "x& <z>");
  }
}

// Fast DDS reads the text before the comment, Cyclone DDS joins the pieces.
TEST(XmlText, SeveralPieces_AreRefused) {
  for (const auto* text :
       {"<a>x<!-- y -->z</a>", "<a><!-- y -->z</a>", "<a>x<!-- y --></a>", "<a><!-- y --></a>",
        "<a>x<![CDATA[z]]></a>", "<a><![CDATA[x]]><![CDATA[z]]></a>"}) {
    const auto document = parse(text);
    ASSERT_TRUE(document);
    EXPECT_CODE(document->root().text(), value_in_pieces);
  }
}

// Inputs that other projects found to be harmful.
TEST(HostileFiles, EachFile_IsRefused) {
  int count = 0;
  for (const char* folder : {"libxml2/errors", "tinyxml2"}) {
    for (const auto& entry : std::filesystem::directory_iterator(test::data_path(folder))) {
      const auto name = entry.path().filename().string();
      if (name == "utf8test.xml" || name == "README.md" || name == "LICENSE.txt") continue;
      EXPECT_FALSE(XmlDocument::parse(data_file(folder + ("/" + name)))) << name;
      ++count;
    }
  }
  EXPECT_EQ(count, 27);
  EXPECT_TRUE(XmlDocument::parse(data_file("tinyxml2/utf8test.xml")));
}

TEST(XmlLines, TextWithinAFile_HasTheFilesLines) {
  const auto at = [](std::string_view text) { return XmlDocument::parse(as_bytes(text), 9); };
  EXPECT_EQ(at("<a>\n<b/></a>")->root().line(), 9);
  EXPECT_EQ(at("<a>\n<b/></a>")->root().first_child().line(), 10);
  EXPECT_EQ(at("<a>\n\a</a>").error().details().line, 10);
  EXPECT_EQ(at("<a>\n</b>").error().details().line, parse("<a>\n</b>").error().details().line + 8);
}

}  // namespace
}  // namespace ddssec::governance
