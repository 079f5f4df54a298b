// Every row was measured with Cyclone DDS 0.10.2, and those of <Id>, texts and unknown elements
// with 0.10.5, too. `ddsperf -i 0` ran with the configuration in CYCLONEDDS_URI. It was noted
// whether it starts, and whether it loads the security plugins.
#include "governance/doctor/effective_security.hpp"

#include <string>

#include <gtest/gtest.h>

#include "tests/unit/governance_doctor/configurations.hpp"

namespace ddssec::governance::doctor::configurations {
namespace {

using Place = ConfigurationPlace;

const std::string kGeneral = "<General><Transport>udp</Transport></General>";

std::string replaced_both(const std::string& name, const std::string& other) {
  auto text = replaced("<" + name + ">", "<" + other + ">");
  const auto at = text.find("</" + name + ">");
  EXPECT_NE(at, text.npos) << name;
  return text.replace(at + 2, name.size(), other);
}

std::string with_switch(const std::string& value) {
  return replaced("<IdentityCA>",
                  "<IncludeOptionalFields>" + value + "</IncludeOptionalFields><IdentityCA>");
}

const std::string kIPv4 = "<General><UseIPv6>false</UseIPv6></General>";

std::string with(const std::string& sections) { return document(domain(sections + security())); }

TEST(EffectiveSecurity, Complete_IsReadWithAllValues) {
  const auto read = effective_security(document(domain(security())), 0, Place::file);
  EXPECT_TRUE(read.problems.empty());
  ASSERT_TRUE(read.applies && read.authentication && read.cryptographic && read.access_control);
  EXPECT_EQ(read.authentication->attribute("initfunction")->text, "init_authentication");
  EXPECT_EQ(read.authentication->value("privatekey")->text, "file:/a/key");
  EXPECT_EQ(read.access_control->value("governance")->text, "file:/a/g");
  EXPECT_EQ(read.access_control->value("crl"), nullptr);
}

// Only in the variable itself may end tags be missing or have no name.
TEST(EffectiveSecurity, FileThenVariable_EachIsReadByItsOwnRules) {
  const std::string part = "<Tracing><Verbosity>none</>";
  const auto read = [&](const std::string& file) {
    return effective_security(file + part, 0, Place::variable, file.size());
  };
  EXPECT_TRUE(read(document(domain(security())) + "\n").problems.empty());
  EXPECT_FALSE(read(replaced("</Governance>", "</>") + "\n").problems.empty());
  EXPECT_FALSE(read("<CycloneDDS><Domain>" + security() + "\n").problems.empty());
  const auto cut_off = "<CycloneDDS><Domain>" + security();
  EXPECT_FALSE(effective_security(cut_off, 0, Place::variable, cut_off.size()).problems.empty());
}

struct Row {
  std::string name, text;
  bool applies;
  Place place = Place::file;
};

class StartedConfiguration : public testing::TestWithParam<Row> {};

TEST_P(StartedConfiguration, EachConfiguration_IsSecuredAsMeasured) {
  const auto read = effective_security(GetParam().text, 0, GetParam().place);
  for (const auto& problem : read.problems) ADD_FAILURE() << problem.line << ' ' << problem.text;
  EXPECT_EQ(read.applies, GetParam().applies);
}

INSTANTIATE_TEST_SUITE_P(
    Table, StartedConfiguration,
    testing::Values(
        Row{"any", document(domain(security(), " Id=\"any\"")), true},
        Row{"AnyInCapitals", document(domain(security(), " id='ANY'")), true},
        Row{"Zeros", document(domain(security(), " Id=\" 00\"")), true},
        Row{"TabBeforeId", document(domain(security(), " Id=\"\t0\"")), true},
        Row{"SignBeforeId", document(domain(security(), " Id=\"+0\"")), true},
        Row{"SignBeforeOldId", document(domain("<Id>+0</Id>" + security())), true},
        Row{"TwoDomainsWithTheSame", document(domain(security()) + domain(security())), true},
        Row{"TwoInOtherDomain",
            document(domain(security()) + domain(security() + security(), " Id=\"5\"")), true},
        Row{"EmptySectionTwice", document(domain("<General/><General/>" + security())), true},
        Row{"UnknownOptionInOtherDomain",
            document(domain("<General><Foo/></General>", " Id=\"5\"") + domain(security())), true},
        Row{"FormerPlace",
            document("<DDSSecurity>" + std::string(kAuthentication) + "</DDSSecurity>"), true},
        Row{"InlineThenFile", document(domain(security())) + ",file:///a", true, Place::variable},
        Row{"OtherDomain", document(domain(security(), " Id=\"1\"")), false},
        Row{"OtherDomainFirst", document(domain("", " Id=\"1\"") + domain(security())), true},
        Row{"OtherDomainHasIt", document(domain(security(), " Id=\"1\"") + domain("")), false},
        Row{"NoSecurity", document(domain("")), false}, Row{"Empty", "", false},
        Row{"Blank", " \n", false}, Row{"DeclarationAlone", "<?xml version=\"1.0\"?>", false},
        Row{"CommentAlone", "<!-- nothing -->", false},
        Row{"CommentAfterRoot", document(domain(security())) + "\n<!-- x -->\n", true},
        Row{"OldId", document(domain("<Id> 0 </Id>" + security())), true},
        Row{"OldIdAny", document(domain("<Id>any</Id>" + security())), true},
        Row{"OldIdEmpty", document(domain("<Id/>" + security())), true},
        Row{"OldIdOther", document(domain("<Id>5</Id>" + security())), false},
        Row{"OldIdOtherThenUnknown", document(domain("<Id>5</Id><Foo/>" + security())), false},
        Row{"OldIdAfterEmptyElement", document(domain("<General/><Id>5</Id>" + security())), false},
        Row{"OldIdSameAfterValues", document(domain(kGeneral + ("<Id>0</Id>" + security()))), true},
        Row{"OldIdSameAsAttribute", document(domain("<Id>0</Id>" + security(), " Id=\"0\"")), true},
        Row{"OldIdInOtherDomain",
            document(domain("<Id>junk</Id>", " Id=\"5\"") + domain(security())), true},
        Row{"OldIdsOfTwoDomains",
            document(domain("<Id>5</Id>" + security()) + domain("<Id>0</Id>" + security())), true},
        Row{"UnknownInOtherDomain",
            document(domain("<Foo/>", " Id=\"5\" foo=\"1\"") + domain(security())), true},
        Row{"TextInOtherDomain",
            document(domain("hello", " Id=\"5\" foo=\"1\"") + domain(security())), true},
        Row{"EmptyValueTwice", with("<General><UseIPv6/><UseIPv6>false</UseIPv6></General>"), true},
        Row{"SectionTwiceWithOtherValues",
            with("<Discovery><Tag>a</Tag></Discovery><Discovery><SPDPInterval>1s</SPDPInterval>"
                 "</Discovery>"),
            true},
        Row{"AttributesOfOneElementApart",
            with(
                "<Internal><HeartbeatInterval min='5ms'/><HeartbeatInterval max='8s'/></Internal>"),
            true},
        Row{"PeersTwice",
            with("<Discovery><Peers><Peer Address='127.0.0.1'/></Peers><Peers><Peer "
                 "Address='127.0.0.2'/></Peers></Discovery>"),
            true},
        Row{"ThreadsWithTheSame",
            with("<Threads><Thread Name='recv'><StackSize>2MB</StackSize></Thread><Thread "
                 "Name='tev'><StackSize>2MB</StackSize></Thread></Threads>"),
            true},
        Row{"ValueInTwoDomains", document(domain(kIPv4) + domain(kIPv4 + security())), true},
        Row{"ValueInRootAndDomain", document(kIPv4 + domain(kIPv4 + security())), true},
        Row{"ValueTwiceInOtherDomain",
            document(domain(kIPv4 + kIPv4, " Id=\"5\"") + domain(security())), true},
        Row{"MovedSection", document(kGeneral + domain(security())), true},
        Row{"Commented", document(domain("<!--" + security() + "-->")), false},
        Row{"SmallLetters", "<cyclonedds><domain><security/></domain></cyclonedds>", true},
        Row{"StartAndEndTagInOtherCase", replaced_both("Governance", "gOVERNANCE"), true},
        Row{"InstructionAfterValue", replaced("</Governance>", "<?x y?></Governance>"), true},
        Row{"DeclarationAfterValue", replaced("</Governance>", "<!DOCTYPE x></Governance>"), true},
        Row{"CommentInValue", replaced("file:/a/g", "file:<!-- x -->/a/g"), true},
        Row{"InstructionWithAngleBracket", replaced("<Security>", "<?x a>b?><Security>"), true},
        Row{"InstructionHidesElement", replaced("<Cryptographic/>", "<?x <Foo/> ?>"), true},
        Row{"InstructionWithoutEndAfterRoot", document(domain(security())) + "<?x", true},
        Row{"InstructionAfterRoot", document(domain(security())) + "<?x?><!-- x --><!X>", true},
        Row{"CommentInTag", replaced("<Domain>", "<Domain <!-- x --> <?x?> Id='0'>"), true},
        Row{"VerticalTab", replaced("<Domain>", "<Domain\vId='0'>"), true},
        Row{"CharacterData", replaced("file:/a/g", "<![CDATA[file:/a/g]]>"), true},
        Row{"CharacterReferences", replaced("file:/a/g", "file:&#47;&#x61;/&#233;"), true},
        Row{"SwitchInCapitals", with_switch("TRUE"), true},
        Row{"SwitchEmpty", with_switch(""), true},
        Row{"SwitchWithBlanks", with_switch(" false "), true},
        Row{"SwitchByDefaultOfVariable", with_switch("${DDSSEC_NOT_SET:-true}"), true},
        Row{"OtherName",
            document(domain("<DDSSecurity>" + std::string(kAuthentication) + "</DDSSecurity>")),
            true},
        Row{"Declaration", "<?xml version=\"1.0\"?>\n<!DOCTYPE x>" + document(domain(security())),
            true},
        Row{"Attributes",
            "<CycloneDDS xmlns=\"https://cdds.io/config\">" + domain(security()) + "</CycloneDDS>",
            true},
        Row{"InlineDomain", domain(security()), true, Place::variable},
        Row{"InlineSecurity", security(), true, Place::variable},
        Row{"InlineAnonymousEnds", "<CycloneDDS><Domain><Security><Cryptographic></></></></>",
            true, Place::variable},
        Row{"InlineWithoutEnds", "<CycloneDDS><Domain>" + security(), true, Place::variable},
        Row{"InlineTwo", "<Tracing><Verbosity>none</></>" + document(domain(security())), true,
            Place::variable},
        Row{"InlineOther", "<Tracing><Verbosity>none</>", false, Place::variable}),
    [](const auto& row) { return row.param.name; });

class BrokenConfiguration : public testing::TestWithParam<Row> {};

TEST_P(BrokenConfiguration, EachConfiguration_HasAProblem) {
  EXPECT_FALSE(effective_security(GetParam().text, 0, GetParam().place).problems.empty());
}

INSTANTIATE_TEST_SUITE_P(
    Table, BrokenConfiguration,
    testing::Values(
        Row{"ElementAfterTextInOtherDomain",
            document(domain("hello<Foo/>", " Id=\"5\"") + domain(security())), false},
        Row{"ElementAfterTextOfSection",
            with("<General><MaxMessageSize>1400B<Foo/></MaxMessageSize></General>"), false},
        Row{"EndTagInOtherCase", replaced("</Governance>", "</gOVERNANCE>"), false},
        Row{"EndTagOfSecurityInOtherCase", replaced("</Security>", "</sECURITY>"), false},
        Row{"StartTagInOtherCase", replaced("<Domain>", "<dOMAIN>"), false},
        Row{"InlineEndTagInOtherCase", replaced("</Governance>", "</gOVERNANCE>"), false,
            Place::variable},
        Row{"InstructionBeforeValue", replaced("file:/a/g", "<?x y?>file:/a/g"), false},
        Row{"InstructionInValue", replaced("file:/a/g", "file:<?x y?>/a/g"), false},
        Row{"DeclarationBeforeValue", replaced("file:/a/g", "<!DOCTYPE x>file:/a/g"), false},
        Row{"InstructionWithoutEnd", replaced("<Security>", "<?x a><Security>"), false},
        Row{"ElementAfterValue", replaced("file:/a/g", "file:/a/g<x/>"), false},
        Row{"UnknownReference", replaced("file:/a/g", "file:/a&nbsp;/g"), false},
        Row{"LongReference", replaced("file:/a/g", "file:/a/&#x0000000000000067;"), false},
        Row{"UnknownReferenceInAttribute", replaced("path=\"", "path=\"a&b"), false},
        Row{"ReferenceTooLarge", replaced("path=\"", "path=\"&#x110000;"), false},
        Row{"QuoteWithoutEnd", replaced("file:/a/p", "'file:/a/p"), false},
        Row{"FormFeed", replaced("<Domain>", "<Domain\fId='0'>"), false},
        Row{"NumberAsName", replaced("<Security>", "<Security><1x/>"), false},
        Row{"SwitchAsNumber", with_switch("1"), false},
        Row{"SwitchAsWord", with_switch("maybe"), false},
        Row{"SwitchByWrongDefault", with_switch("${DDSSEC_NOT_SET:-x}"), false},
        Row{"TextAlone", "hello", false}, Row{"BeginningOfAName", with("<Gen/>"), false},
        Row{"ValueTwice",
            with("<General><UseIPv6>false</UseIPv6><UseIPv6>false</UseIPv6></General>"), false},
        Row{"ValueTwiceInTwoSections", with(kIPv4 + kIPv4), false},
        Row{"ValueTwiceInSectionsApart", with(kIPv4 + "<Discovery/>" + kIPv4), false},
        Row{"ValueTwiceDeeper",
            with("<Discovery><Ports><Base>7400</Base></Ports><Ports><Base>7400</Base></Ports>"
                 "</Discovery>"),
            false},
        Row{"ValueTwiceUnderBothNames",
            with("<Internal><AckDelay>1ms</AckDelay></Internal><Unsupported><AckDelay>1ms"
                 "</AckDelay></Unsupported>"),
            false},
        Row{"ValueTwiceInBothPlaces",
            with(
                "<General><FragmentSize>1300B</FragmentSize></General><Internal><FragmentSize>1300B"
                "</FragmentSize></Internal>"),
            false},
        Row{"ValueOfThreadTwice",
            with("<Threads><Thread Name='recv'><StackSize>2MB</StackSize><StackSize>2MB</StackSize>"
                 "</Thread></Threads>"),
            false},
        Row{"AttributeTwice", with("<Threads><Thread Name='recv' Name='tev'/></Threads>"), false},
        Row{"AttributeTwiceInTwoElements",
            with("<Internal><HeartbeatInterval min='5ms'/><HeartbeatInterval "
                 "min='5ms'/></Internal>"),
            false},
        Row{"LibraryAttributeTwice", replaced("path=", "path='x' path="), false},
        Row{"TextInList", with("<Discovery><Peers>text</Peers></Discovery>"), false},
        Row{"TextInPeer",
            with("<Discovery><Peers><Peer Address='::1'>x</Peer></Peers></Discovery>"), false},
        Row{"TextBefore", "hello" + document(domain(security())), false},
        Row{"TextAfter", document(domain(security())) + "hello", false},
        Row{"TwoRoots", document(domain(security())) + document(""), false},
        Row{"TextInRoot", document("hello" + domain(security())), false},
        Row{"TextInDomain", document(domain("hello" + security())), false},
        Row{"TextAfterElement",
            document(domain("<General><Transport>udp</Transport>hello</General>", " Id=\"5\"")),
            false},
        Row{"UnknownInRoot", document("<Foo/>" + domain(security())), false},
        Row{"UnknownInDomain", document(domain(security() + "<Foo/>")), false},
        Row{"SecurityInRoot", document(security()), false},
        Row{"DomainInDomain", document(domain(domain(security()))), false},
        Row{"AttributeOfRoot", "<CycloneDDS foo=\"1\">" + domain(security()) + "</CycloneDDS>",
            false},
        Row{"AttributeOfDomain", document(domain(security(), " foo=\"1\" Id=\"5\"")), false},
        Row{"InlineUnknown", "<Foo/>", false, Place::variable},
        Row{"InlineUnknownInDomain", "<Domain><Foo/></Domain>", false, Place::variable},
        Row{"OldIdWord", document(domain("<Id>junk</Id>" + security())), false},
        Row{"OldIdHexadecimal", document(domain("<Id>0x0</Id>" + security())), false},
        Row{"OldIdAttribute", document(domain("<Id a=\"1\">0</Id>")), false},
        Row{"OldIdOtherAfterValues", document(domain(kGeneral + ("<Id>5</Id>" + security()))),
            false},
        Row{"OldIdOtherAfterAttribute", document(domain("<Id>5</Id>" + security(), " Id=\"any\"")),
            false},
        Row{"BlankAfterId", document(domain(security(), " Id=\" 0 \"")), false},
        Row{"BlankBeforeAny", document(domain(security(), " Id=\" any\"")), false},
        Row{"BlankAfterOtherId", document(domain(security()) + domain("", " Id=\"5 \"")), false},
        Row{"TwoInDomain", document(domain(security() + security())), false},
        Row{"TwoInDomainUnderBothNames", document(domain(security() + "<DDSSecurity/>")), false},
        Row{"SecondIsEmpty", document(domain(security()) + domain("<Security/>")), false},
        Row{"PluginTwice", replaced("<Cryptographic/>", "<Cryptographic/><Cryptographic/>"), false},
        Row{"BlankInEnd", replaced("</Governance>", "</Governance\n>"), false},
        Row{"BlankInEndOfSection", document(domain("<General></General >" + security())), false},
        Row{"BlankBeforeEnd", replaced("</Domain>", "</ Domain>"), false},
        Row{"ByteOrderMark", "\xEF\xBB\xBF" + document(domain(security())), false},
        Row{"AttributeOfSection", document(domain("<General a=\"1\"/>" + security())), false},
        Row{"TextInSection", document(domain("<General>text</General>" + security())), false},
        Row{"InlineThenText", document(domain(security())) + " x", false, Place::variable},
        Row{"WordAsId", document(domain(security(), " Id=\"x\"")), false},
        Row{"HexadecimalId", document(domain(security(), " Id=\"0x0\"")), false},
        Row{"OtherRoot", "<CycloneDDSX>" + domain(security()) + "</CycloneDDSX>", false},
        Row{"UnknownElement", replaced("<IdentityCA>", "<Foo/><IdentityCA>"), false},
        Row{"UnknownAttribute", replaced("<Security>", "<Security a=\"1\">"), false},
        Row{"UnknownOfLibrary", replaced("path=", "pahth="), false},
        Row{"Twice", replaced("<Governance>", "<Governance>x</Governance><Governance>"), false},
        Row{"Text", replaced("<Security>", "<Security>text"), false},
        Row{"WrongEnd", replaced("</Governance>", "</Governanc>"), false},
        Row{"AnonymousEndInFile", replaced("</Governance>", "</>"), false},
        Row{"CutOff", document(domain(security())).substr(0, 300), false},
        Row{"CommentWithoutEnd", replaced("<Security>", "<!--<Security>"), false}),
    [](const auto& row) { return row.param.name; });

TEST(EffectiveSecurity, OldIdOfOtherDomain_IsNamed) {
  const auto text = document(domain("<Id>7</Id>" + security()));
  EXPECT_EQ(effective_security(text, 0, Place::file).other_domain, "7");
  EXPECT_TRUE(effective_security(text, 7, Place::file).applies);
}

TEST(EffectiveSecurity, OtherDomain_IsNamed) {
  const auto text = document(domain(security(), " Id=\"7\""));
  EXPECT_EQ(effective_security(text, 0, Place::file).other_domain, "7");
  EXPECT_TRUE(effective_security(text, 7, Place::file).applies);
}

}  // namespace
}  // namespace ddssec::governance::doctor::configurations
