// What is refused before a parser sees it.
#include "governance/xml_check.hpp"

#include "governance/xml.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using namespace std::string_literals;

Result<XmlDocument> parse(std::string_view text) { return XmlDocument::parse(as_bytes(text)); }

struct Row {
  const char* name;
  std::string text;
  Code code;
  int line = 1;
};
void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

class HostileXml : public testing::TestWithParam<Row> {};
TEST_P(HostileXml, EachText_IsRefusedBeforeItIsParsed) {
  const auto status = check_xml(GetParam().text);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code(), GetParam().code) << status.error().to_sentence();
  EXPECT_EQ(status.error().details().line, GetParam().line) << status.error().to_sentence();
  EXPECT_FALSE(parse(GetParam().text));
}

// The path may be a link to any file that the process may read, so its content must not get into an
// event.
TEST(XmlErrors, RefusedText_IsNotQuoted) {
  for (const auto* text :
       {"hunter2", "<a>&hunter2;</a>", "<a>x &hunter2", "<a/>hunter2", "<a/>&hunter2;", "<hunter2",
        "<a b=hunter2/>", "<a b='x'hunter2/>", "</hunter2>", "</a hunter2>", "<a hunter2>",
        "<?hunter2?><a/>", "<!hunter2>", "<?xml version='1.0' encoding='hunter2 x'?><a/>",
        "<?xml encoding=hunter2?><a/>"}) {
    const auto status = check_xml(text);
    ASSERT_FALSE(status) << text;
    EXPECT_EQ(status.error().to_sentence().find("hunter2"), std::string::npos)
        << status.error().to_sentence();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Octets, HostileXml,
    testing::Values(Row{"NUL at the end", "<a/>\0"s, Code::xml_control_character},
                    Row{"NUL and more", "<a/>\0<b/>"s, Code::xml_control_character},
                    Row{"NUL in text", "<a>\nx\0y</a>"s, Code::xml_control_character, 2},
                    Row{"bell", "<a>\a</a>", Code::xml_control_character},
                    Row{"UTF-16 with mark", "\xFE\xFF\0<\0a"s, Code::xml_encoding},
                    Row{"UTF-16 other end", "\xFF\xFE<\0a\0"s, Code::xml_encoding},
                    Row{"UTF-16 without mark", "<\0a\0/\0>\0"s, Code::xml_control_character},
                    Row{"Latin-1", "<a>\n\xE9</a>", Code::xml_encoding, 2},
                    Row{"overlong", "<a>\xC0\xAF</a>", Code::xml_encoding},
                    Row{"overlong in three", "<a>\xE0\x80\xAF</a>", Code::xml_encoding},
                    Row{"surrogate", "<a>\xED\xA0\x80</a>", Code::xml_encoding},
                    Row{"beyond Unicode", "<a>\xF4\x90\x80\x80</a>", Code::xml_encoding},
                    Row{"cut", "<a>\xC3", Code::xml_encoding},
                    Row{"not a character", "<a>\xEF\xBF\xBF</a>", Code::xml_encoding},
                    Row{"declared Latin-1", "<?xml version='1.0' encoding='ISO-8859-1'?><a/>",
                        Code::xml_encoding},
                    Row{"declared UTF-16", "<?xml version='1.0' ENCODING=\"UTF-16\"?><a/>",
                        Code::xml_encoding},
                    Row{"declared UTF-7", "\xEF\xBB\xBF<?xml version='1.0' encoding='utf-7'?><a/>",
                        Code::xml_encoding}));

INSTANTIATE_TEST_SUITE_P(
    Markup, HostileXml,
    testing::Values(
        Row{"DOCTYPE", "<!DOCTYPE dds [<!ENTITY e 'x'>]><dds>&e;</dds>", Code::xml_doctype},
        Row{"DOCTYPE in small letters", "<!doctype dds><dds/>", Code::xml_doctype},
        Row{"entity declaration", "<dds>\n<!ENTITY e 'x'></dds>", Code::xml_doctype, 2},
        Row{"conditional section", "<dds><![INCLUDE[x]]></dds>", Code::xml_doctype},
        Row{"unknown entity", "<a>&e;</a>", Code::xml_entity},
        Row{"entity in capitals", "<a>&LT;</a>", Code::xml_entity},
        Row{"entity in an attribute", "<a b='&e;'/>", Code::xml_entity},
        Row{"ampersand alone", "<a>x & y</a>", Code::xml_entity},
        Row{"ampersand at the end", "<a>x &", Code::xml_entity},
        Row{"character 0", "<a>&#0;</a>", Code::xml_entity},
        Row{"character of no use", "<a>&#xFFFE;</a>", Code::xml_entity},
        Row{"surrogate by number", "<a>&#xD800;</a>", Code::xml_entity},
        Row{"number too long", "<a>&#x00000000000041;</a>", Code::xml_entity},
        Row{"number with sign", "<a>&#-65;</a>", Code::xml_entity},
        Row{"number in capitals", "<a>&#X41;</a>", Code::xml_entity},
        Row{"instruction", "<a><?php x?></a>", Code::xml_processing_instruction},
        Row{"stylesheet", "<?xml version='1.0'?>\n<?xml-stylesheet href='x'?><a/>",
            Code::xml_processing_instruction, 2},
        Row{"revision after a comment", "<!-- x --><?ddssec revision=\"7\"?><a/>",
            Code::xml_processing_instruction},
        Row{"revision in the root", "<a><?ddssec revision=\"7\"?></a>",
            Code::xml_processing_instruction},
        Row{"revision at the end", "<a/><?ddssec revision=\"7\"?>",
            Code::xml_processing_instruction},
        Row{"two revisions", "<?ddssec revision=\"7\"?><?ddssec revision=\"8\"?><a/>",
            Code::xml_processing_instruction},
        Row{"revision of 0", "<?ddssec revision=\"0\"?><a/>", Code::value_not_revision},
        Row{"revision with a zero", "<?ddssec revision=\"07\"?><a/>", Code::value_not_revision},
        Row{"revision too large", "<?ddssec revision=\"4294967296\"?><a/>",
            Code::value_not_revision},
        Row{"negative revision", "<?ddssec revision=\"-1\"?><a/>", Code::value_not_revision},
        Row{"empty revision", "<?ddssec revision=\"\"?><a/>", Code::value_not_revision},
        Row{"revision in other quotes", "<?ddssec revision='7'?><a/>", Code::value_not_revision},
        Row{"another word", "<?ddssec version=\"7\"?><a/>", Code::value_not_revision},
        Row{"revision without an end", "<?ddssec revision=\"7\"><a/>", Code::xml_not_well_formed},
        Row{"second declaration", "<?xml version='1.0'?><?xml version='1.0'?><a/>",
            Code::xml_processing_instruction},
        Row{"late declaration", "\n<?xml version='1.0'?><a/>", Code::xml_processing_instruction,
            2}));

INSTANTIATE_TEST_SUITE_P(
    Form, HostileXml,
    testing::Values(Row{"empty", "", Code::xml_not_well_formed},
                    Row{"blank", " \n", Code::xml_not_well_formed, 2},
                    Row{"two roots", "<a/>\n<b/>", Code::xml_not_well_formed, 2},
                    Row{"text before", "x<a/>", Code::xml_not_well_formed},
                    Row{"text after", "<a/>x", Code::xml_not_well_formed},
                    Row{"reference after", "<a/>&lt;", Code::xml_not_well_formed},
                    Row{"CDATA after", "<a/><![CDATA[x]]>", Code::xml_not_well_formed},
                    Row{"not closed", "<a>", Code::xml_not_well_formed},
                    Row{"closed twice", "<a/></a>", Code::xml_not_well_formed},
                    Row{"end first", "</a>", Code::xml_not_well_formed},
                    Row{"comment not closed", "<a><!-- x", Code::xml_not_well_formed},
                    Row{"two hyphens", "<a><!-- x -- y --></a>", Code::xml_not_well_formed},
                    Row{"CDATA not closed", "<a><![CDATA[x</a>", Code::xml_not_well_formed},
                    Row{"CDATA end in text", "<a>]]></a>", Code::xml_not_well_formed},
                    Row{"declaration not closed", "<?xml version='1.0'", Code::xml_not_well_formed},
                    Row{"markup in declaration", "<?xml <a> ?>", Code::xml_not_well_formed},
                    Row{"encoding not quoted", "<?xml encoding=UTF-8?><a/>",
                        Code::xml_not_well_formed},
                    Row{"no name", "< a/>", Code::xml_not_well_formed},
                    Row{"number as name", "<1/>", Code::xml_not_well_formed},
                    Row{"bracket in attribute", "<a b='<'/>", Code::xml_not_well_formed},
                    Row{"no value", "<a b/>", Code::xml_not_well_formed},
                    Row{"no quotes", "<a b=c/>", Code::xml_not_well_formed},
                    Row{"quote not closed", "<a b='c/>", Code::xml_not_well_formed},
                    Row{"attributes together", "<a b='c'd='e'/>", Code::xml_not_well_formed},
                    Row{"end tag with attribute", "<a></a b='c'>", Code::xml_not_well_formed},
                    Row{"tag not closed", "<a", Code::xml_not_well_formed},
                    Row{"end tag not closed", "<a></a", Code::xml_not_well_formed}));

class GoodXml : public testing::TestWithParam<const char*> {};
TEST_P(GoodXml, EachText_Passes) {
  const auto document = parse(GetParam());
  EXPECT_TRUE(document) << document.error().to_sentence();
}
INSTANTIATE_TEST_SUITE_P(
    Table, GoodXml,
    testing::Values("<a/>", " <a/> ", "\xEF\xBB\xBF<a/>", "<?xml version=\"1.0\"?><a/>",
                    "<?xml version='1.0' encoding='utf-8' standalone='yes'?>\r\n<a></a >\r\n",
                    "<!-- <!DOCTYPE a> &e; <?x?> --><a/>", "<a><!-- <b> & --></a>",
                    "<a><![CDATA[<!DOCTYPE a> &e; <?x?> ]] > <b>]]></a>",
                    "<a b='\"' c=\"'>\">&lt;&#65;&#x41;&#x10FFFF;</a>", "<a\n b = 'c'\t/>",
                    "<\xC3\xA9>\xE2\x82\xAC\xF0\x9F\x98\x80</\xC3\xA9>", "<a.b-c:d_1/>",
                    "<a>]]</a>", "<a>></a>"));

TEST(XmlCheck, MismatchedTags_AreLeftToTheParser) {
  EXPECT_TRUE(check_xml("<a></b>"));
  EXPECT_CODE(parse("<a></b>"), xml_not_well_formed);
}

TEST(XmlCheck, Depth_IsBounded) {
  const auto nested = [](int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) text += "<a>";
    for (int i = 0; i < depth; ++i) text += "</a>";
    return text;
  };
  EXPECT_TRUE(parse(nested(kMaxXmlDepth)));
  EXPECT_CODE(parse(nested(kMaxXmlDepth + 1)), xml_too_deep);
  EXPECT_CODE(parse(nested(52'000)), xml_too_deep);
}

// tinyxml2 compares each attribute of an element with all before it. 100,000 of them took minutes.
TEST(XmlCheck, AttributesOfAnElement_AreBounded) {
  const auto with = [](int attributes) {
    std::string text = "<a>\n<b";
    for (int i = 0; i < attributes; ++i) text += " xmlns:a" + std::to_string(i) + "='x'";
    return text + "/><c d='e'/></a>";
  };
  EXPECT_TRUE(parse(with(kMaxXmlAttributes)));
  const auto refused = parse(with(kMaxXmlAttributes + 1));
  EXPECT_CODE(refused, xml_too_many_attributes);
  EXPECT_EQ(refused.error().details().line, 2);
  EXPECT_CODE(parse(with(500'000)), xml_too_many_attributes);
}

TEST(XmlCheck, Size_IsBounded) {
  EXPECT_CODE(parse(std::string(kMaxXmlOctets + 1, ' ')), xml_too_large);
}

TEST(XmlCheck, Elements_AreBounded) {
  std::string text = "<a>";
  for (std::size_t i = 0; i < kMaxXmlElements; ++i) text += "<b/>";
  EXPECT_CODE(parse(text + "</a>"), xml_too_large);
}

}  // namespace
}  // namespace ddssec::governance
