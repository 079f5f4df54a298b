// Two readers of one file: ours, and that of OpenSSL, which stock products use. The lines around
// the two parts are not signed, so every participant that passes a document on can change them.
// OpenSSL must read what ours accepts in the same way, or refuse it.
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "pki/smime_diagnosis.hpp"
#include "pki/unverified_document.hpp"
#include "pki_fixture.hpp"
#include "tests/support/code_of.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kOurs = "OURS", kOther = "OTHER";

std::string with_boundary(std::string file, std::string_view boundary) {
  const auto at = file.find("boundary=\"") + 10;
  const auto old = file.substr(at, file.find('"', at) - at);
  for (auto found = file.find(old); found != file.npos; found = file.find(old, found + 1))
    file.replace(found, old.size(), boundary);
  std::erase(file, '\r');
  return file;
}

// A signed document whose text contains another signed document with its boundary lines.
class TwoReaders : public testing::Test {
 protected:
  std::string sign(std::string_view text) const {
    return std::string(as_text(*ca_.sign_document(as_bytes(text), kNow, test_random())));
  }

  Authority ca_ = make_ca("CN=Permissions CA");
  std::string inner_ = with_boundary(sign("<dds>open</dds>\n"), kOther);
  std::string outer_ = with_boundary(
      sign("<dds><![CDATA[\n" + inner_.substr(inner_.find("--OTHER\n")) + "]]></dds>\n"), kOurs);
};

std::size_t below(std::mt19937_64& random, std::size_t end) { return random() % end; }

// Returns a piece that means something to one of the readers.
std::string_view random_piece(std::mt19937_64& random) {
  static const std::string blanks(1100, ' '), returns(1100, '\r'), letters(1000, 'x');
  static const std::vector<std::string> pieces = {"\"",
                                                  "\\",
                                                  "(",
                                                  ")",
                                                  ";",
                                                  "=",
                                                  ":",
                                                  " ",
                                                  "\t",
                                                  "\r",
                                                  "\n",
                                                  "\n ",
                                                  "\r\n\t",
                                                  "\n\n",
                                                  "\v",
                                                  "\x80",
                                                  "'",
                                                  ",",
                                                  "a",
                                                  "--",
                                                  "OURS",
                                                  "OTHER",
                                                  "boundary=",
                                                  "boundary=OURS",
                                                  "boundary=OTHER",
                                                  "boundary=\"OTHER\"",
                                                  "; boundary=OTHER",
                                                  "; boundary=\"OTHER\"",
                                                  "; x=a\"",
                                                  "; w=\"",
                                                  "; v=(",
                                                  "\"; boundary=OTHER; v=\"",
                                                  "(; boundary=OTHER;)",
                                                  "\nX: (a",
                                                  "\nX: a;",
                                                  "\n ; boundary=OTHER",
                                                  "\n\tboundary=OTHER;",
                                                  "Content-Type: ",
                                                  "\nContent-Type: multipart/signed",
                                                  "multipart/signed",
                                                  "application/pkcs7-mime",
                                                  "--OURS\n",
                                                  "--OTHER\n",
                                                  "--OTHER--\n",
                                                  "\n--OTHER\n",
                                                  "Content-Transfer-Encoding: base64\n",
                                                  "=\n",
                                                  "M\n",
                                                  blanks,
                                                  returns,
                                                  letters};
  return pieces[below(random, pieces.size())];
}

// Returns the places that are not signed: the header, the boundary lines, the header of the
// signature.
std::vector<std::pair<std::size_t, std::size_t>> unsigned_places(const std::string& file) {
  const auto first = file.find("--OURS\n") + 8;
  const auto second = file.rfind("\n--OURS\n");
  const auto third = file.rfind("\n--OURS--");
  return {{0, first},
          {0, first},
          {0, first},
          {second, std::min(second + 200, third)},
          {third - 20, file.size()}};
}

std::string mutated(std::string file, std::mt19937_64& random) {
  for (auto changes = 1 + below(random, 4); changes > 0; --changes) {
    const auto places = unsigned_places(file);
    const auto [begin, end] = places[below(random, places.size())];
    if (begin >= end || end > file.size()) return file;
    const auto at = begin + below(random, end - begin);
    const auto removed = below(random, 3) == 0 ? below(random, 12) : 0;
    file.replace(at, removed, random_piece(random));
  }
  return file;
}

TEST_F(TwoReaders, WhatOursAccepts_OpensslReadsInTheSameWay) {
  constexpr int kCases = 100'000;
  std::mt19937_64 random(20261123);
  int accepted = 0;
  for (int i = 0; i < kCases; ++i) {
    const auto file = mutated(outer_, random);
    const auto ours = read_document(as_bytes(file));
    if (!ours) continue;
    ++accepted;
    const auto same = check_same_reading(*ours, as_bytes(file));
    ASSERT_TRUE(same) << "case " << i << ": " << same.error().message() << "\n" << file;
  }
  EXPECT_GT(accepted, kCases / 200);
}

// Our reader read each of these as OURS, and OpenSSL read it as OTHER, or could have done so.
TEST_F(TwoReaders, HeadersWithTwoReadings_AreRefused) {
  const auto header =
      outer_.substr(outer_.find("Content-Type"), outer_.find("\n\n") - outer_.find("Content-Type"));
  const std::string start =
      "Content-Type: multipart/signed; protocol=\"application/x-pkcs7-signature\"";
  const std::string returns(1100, '\r');
  for (const auto& line : std::vector<std::string>{
           start + "; x=a\"; boundary=OURS; w=\"; boundary=OTHER; v=\"",
           start + "; x=(; boundary=OURS; w=); boundary=OTHER",
           start + "; x=a\\; boundary=OURS",
           start + "; boundary=OURS; boundary=OTHER",
           start + "; boundary=OURS; Boundary=OTHER",
           start + "; boundary=OTHER OURS",
           start + "; boundary=OTHER\n OURS",
           start + "; boundary=OURS\nX: (\n ; boundary=OTHER",
           start + "; boundary=OURS\nX: (;\n boundary=OTHER",
           start + "; x=\"a;\n boundary=OTHER;\n \"; boundary=OURS",
           start + ";" + returns + "\n boundary=OURS",
           start + "; boundary=\"OURS",
           start + "; boundary=OURS; x=a/b",
           start + "; boundary=OURS; x=",
       }) {
    const auto file = replaced(outer_, header, line);
    EXPECT_THAT(test::code_of(read_document(as_bytes(file))),
                testing::AnyOf(Code::smime_malformed, Code::smime_content_type))
        << line;
  }
  EXPECT_TRUE(
      read_document(as_bytes(replaced(outer_, header, start + "; boundary=OURS; x=\"(\""))));
  EXPECT_TRUE(read_document(as_bytes(replaced(outer_, header, start + ";\n boundary=OURS"))));
}

TEST_F(TwoReaders, ABoundaryWithinALine_IsRefused) {
  const auto text = "<dds>" + std::string(1018, ' ') + "--OURS\n</dds>\n";
  EXPECT_CODE(read_document(as_bytes(with_boundary(sign(text), kOurs))), smime_malformed);
  EXPECT_TRUE(read_document(as_bytes(with_boundary(sign(text), kOther))));
  EXPECT_CODE(read_document(as_bytes(
                  replaced(outer_, "--OURS\n", "--OURS" + std::string(1010, '\r') + "\n"))),
              smime_malformed);
}

TEST_F(TwoReaders, DocumentThatOpensslReadsDifferently_IsRefusedAsAmbiguous) {
  auto ours = read_document(as_bytes(outer_));
  ASSERT_TRUE(ours);
  EXPECT_TRUE(check_same_reading(*ours, as_bytes(outer_)));
  EXPECT_FALSE(examine_document(as_bytes(outer_)).ambiguous);
  EXPECT_CODE(check_same_reading(*ours, as_bytes(inner_)), smime_malformed);
  auto other = *ours;
  other.signed_octets.back() ^= 1;
  EXPECT_CODE(check_same_reading(other, as_bytes(outer_)), smime_malformed);
  other = *ours;
  other.signature.back() ^= 1;
  EXPECT_CODE(check_same_reading(other, as_bytes(outer_)), smime_malformed);
  EXPECT_TRUE(check_same_reading(*ours, as_bytes("nothing that OpenSSL reads")));
}

// Only padding may end the base64 text, because OpenSSL ignores what follows it.
TEST_F(TwoReaders, PaddingWithinTheSignature_IsRefused) {
  const auto begin = outer_.rfind("smime.p7s\"\n\n") + 12;
  for (const auto* changed : {"=", "==", "===="}) {
    auto file = outer_;
    file.replace(begin + 8, std::string_view(changed).size(), changed);
    EXPECT_CODE(read_document(as_bytes(file)), smime_signature_malformed);
  }
}

}  // namespace
}  // namespace ddssec::pki
