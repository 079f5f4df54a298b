// Botan's distinguished names. Where our result differs, the test says why.
#include <map>
#include <sstream>

#include "pki/openssl.hpp"
#include "pki/subject_name.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

using Record = std::map<std::string, std::string>;

// Reads "Key = value" lines. A new record begins when its first key comes again.
std::vector<Record> records(const std::string& file, const std::string& first_key) {
  const auto octets = data_file("botan-x509-dn/" + file);
  std::istringstream lines{std::string(as_text(octets))};
  std::vector<Record> out;
  std::string line, section;
  while (std::getline(lines, line)) {
    if (line.starts_with('[')) section = line;
    const auto equals = line.find(" =");
    if (line.empty() || line[0] == '#' || line[0] == '[' || equals == line.npos) continue;
    const auto key = line.substr(0, equals);
    if (key == first_key) out.push_back({{"section", section}});
    out.back()[key] = line.size() > equals + 3 ? line.substr(equals + 3) : "";
  }
  return out;
}

// Returns a certificate's name from DER, in our form.
SubjectName name_from_der(const Bytes& der) {
  const auto* position = der.data();
  const NamePtr name(d2i_X509_NAME(nullptr, &position, static_cast<long>(der.size())));
  return *SubjectName::parse(name_rfc2253(name.get()));
}

TEST(BotanNames, ValidOnes_MeanWhatTheirDerSays) {
  int checked = 0;
  for (const auto& record : records("x509_dn_valid.vec", "Input")) {
    const auto& input = record.at("Input");
    const auto name = SubjectName::parse(input);
    // The empty name would match no certificate, and a name with a NUL would be read as a shorter
    // name.
    if (input.empty() || input.find("\\00") != input.npos) {
      EXPECT_CODE(name, subject_name_malformed);
      continue;
    }
    ASSERT_TRUE(name) << input << name.error().to_sentence();
    EXPECT_TRUE(name->matches(name_from_der(*from_hex(record.at("DER"))))) << input;
    ++checked;
  }
  EXPECT_GE(checked, 15);
}

TEST(BotanNames, InvalidOnes_AreRefused) {
  // DDS-Security 1.2 allows blanks around '='. RFC 4514 allows '#' and '=' inside a value.
  const std::map<std::string, bool> allowed = {
      {"CN =Alice", true}, {"CN=A#B", true}, {"CN=A=B", true}};
  int refused = 0;
  for (const auto& record : records("x509_dn_invalid.vec", "Input")) {
    const auto& input = record.at("Input");
    EXPECT_EQ(SubjectName::parse(input).has_value(), allowed.contains(input)) << input;
    ++refused;
  }
  EXPECT_GE(refused, 20);
}

TEST(BotanNames, UnequalPairs_DoNotMatch) {
  int differ = 0, same = 0;
  for (const auto& record : records("x509_dn_ordering.vec", "DN1")) {
    const auto one = SubjectName::parse(record.at("DN1"));
    const auto two = SubjectName::parse(record.at("DN2"));
    if (!one || !two) continue;  // one of the names is empty
    const bool reordered =
        record.at("DN1") == "CN=\"abc\",CN=\"foo\"" && record.at("DN2") == "CN=\"foo\",CN=\"abc\"";
    if (record.at("section") == "[Unequal]" && !reordered) {
      EXPECT_FALSE(one->matches(*two)) << record.at("DN1") << " | " << record.at("DN2");
      ++differ;
    } else if (reordered) {
      EXPECT_TRUE(one->matches(*two));  // in DDS-Security 1.2 the order is irrelevant
    } else {
      // Botan folds case and blanks, as X.520 allows. We compare octets, because DDS-Security wants
      // equal values, peers compare octets, and folding would let two certificates share
      // permissions.
      EXPECT_FALSE(one->matches(*two)) << record.at("DN1") << " | " << record.at("DN2");
      ++same;
    }
  }
  EXPECT_GE(differ, 8);
  EXPECT_GE(same, 10);
}

}  // namespace
}  // namespace ddssec::pki
