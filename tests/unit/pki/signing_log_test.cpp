#include "pki/signing_log.hpp"

#include "pki/issue_log.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

using Standing = SigningLog::Standing;

std::string line(std::string_view text, const Certificate& ca, std::string_view file) {
  return SigningLog::signed_line(as_bytes(text), ca, file, kNow);
}

TEST(SigningLog, TextsItsCaSigned_AreKnownWhateverTheLineEnds) {
  const auto ca = make_ca();
  const auto other = make_ca();
  const auto log = SigningLog::parse(as_bytes(line("a\nb\n", ca.certificate(), "/p")));
  EXPECT_EQ(log.standing(as_bytes("a\r\nb\r\n"), ca.certificate()), Standing::current);
  EXPECT_EQ(log.standing(as_bytes("a\nb"), ca.certificate()), Standing::unknown);
  EXPECT_EQ(log.standing(as_bytes("a\nb\n"), other.certificate()), Standing::unknown);
  EXPECT_EQ(SigningLog().standing(as_bytes("a"), ca.certificate()), Standing::unknown);
}

TEST(SigningLog, ALaterDocumentOfTheSameFile_Supersedes) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto text = line("old", c, "/p") + line("new", c, "/p") + line("copied", c, "/a") +
                    line("copied", c, "/b") + line("next", c, "/a");
  const auto log = SigningLog::parse(as_bytes(text));
  EXPECT_EQ(log.standing(as_bytes("old"), c), Standing::superseded);
  EXPECT_EQ(log.standing(as_bytes("new"), c), Standing::current);
  EXPECT_EQ(log.standing(as_bytes("copied"), c), Standing::current) << "it is still in /b";
  const auto again = SigningLog::parse(as_bytes(text + line("old", c, "/p")));
  EXPECT_EQ(again.standing(as_bytes("old"), c), Standing::current);
  EXPECT_EQ(again.standing(as_bytes("new"), c), Standing::superseded);
}

// A folder was moved from /a to /b, a narrower document was signed there, and the former document
// was put back.
TEST(SigningLog, AFormerDocument_InAFileForWhichAnotherWasSignedLater_IsSuperseded) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto text = line("wide", c, "/a") + line("narrow", c, "/b");
  const auto log = SigningLog::parse(as_bytes(text));
  const auto standing = [&](std::string_view document, const std::vector<std::string>& files) {
    return log.standing(as_bytes(document), c, files);
  };
  EXPECT_EQ(standing("wide", {"/b"}), Standing::superseded);
  EXPECT_EQ(standing("wide", {"/a"}), Standing::current);
  EXPECT_EQ(standing("wide", {"/c"}), Standing::current) << "moved, and nothing was signed since";
  EXPECT_EQ(standing("narrow", {"/b"}), Standing::current);
  EXPECT_EQ(standing("narrow", {"/a"}), Standing::current) << "signed elsewhere, and put there";
  EXPECT_EQ(standing("wide", {"/a", "/b"}), Standing::superseded) << "two names of one file";
}

// One document was signed for two files. It was replaced in /a, and then signed again for /b.
TEST(SigningLog, ADocumentThatWasReplacedInAFile_StaysSupersededThere) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto text = line("both", c, "/a") + line("both", c, "/b") + line("narrow", c, "/a") +
                    line("both", c, "/b");
  const auto log = SigningLog::parse(as_bytes(text));
  EXPECT_EQ(log.standing(as_bytes("both"), c, {"/a"}), Standing::superseded);
  EXPECT_EQ(log.standing(as_bytes("both"), c, {"/b"}), Standing::current);
}

TEST(SigningLog, ACaThatSignsTheSameTextAnew_SupersedesNothing) {
  const auto old = make_ca();
  const auto next = make_ca();
  const auto text = line("a", old.certificate(), "/p") + line("a", next.certificate(), "/p");
  const auto log = SigningLog::parse(as_bytes(text));
  EXPECT_EQ(log.standing(as_bytes("a"), old.certificate()), Standing::current);
  EXPECT_EQ(log.standing(as_bytes("a"), next.certificate()), Standing::current);
  const auto later = SigningLog::parse(as_bytes(text + line("b", next.certificate(), "/p")));
  EXPECT_EQ(later.standing(as_bytes("a"), old.certificate()), Standing::superseded);
  EXPECT_EQ(later.standing(as_bytes("b"), old.certificate()), Standing::unknown);
}

TEST(SigningLog, Extension_NotYetInPlace_LeavesTheExtendedTextCurrent) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto extension = [&](std::string_view text, std::string_view old) {
    return SigningLog::signed_line(as_bytes(text), c, "/p", WallTime(), as_bytes(old));
  };
  const auto text =
      line("wide", c, "/p") + line("a", c, "/p") + extension("b", "a\r") + extension("c", "b");
  const auto log = SigningLog::parse(as_bytes(text));
  EXPECT_EQ(log.standing(as_bytes("wide"), c), Standing::superseded);
  for (const auto* one : {"a", "b", "c"})
    EXPECT_EQ(log.standing(as_bytes(one), c), Standing::current) << one;
  const auto narrower = SigningLog::parse(as_bytes(text + line("d", c, "/p")));
  for (const auto* one : {"wide", "a", "b", "c"})
    EXPECT_EQ(narrower.standing(as_bytes(one), c), Standing::superseded) << one;
}

TEST(SigningLog, ExtensionsOfEachOther_AreReadToAnEnd) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  std::string text = line("x", c, "/p");
  for (const auto& [next, old] : {std::pair("b", "a"), std::pair("a", "b")})
    text += SigningLog::signed_line(as_bytes(std::string_view(next)), c, "/p", WallTime(),
                                    as_bytes(std::string_view(old)));
  EXPECT_EQ(SigningLog::parse(as_bytes(text)).standing(as_bytes("x"), c), Standing::superseded);
}

TEST(SigningLog, LastTextOfAFile_IsKnownWhicheverCaSignedIt) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto log = SigningLog::parse(
      as_bytes(line("old", c, "/p") + line("new\n", c, "/p") + line("other", c, "/q")));
  EXPECT_TRUE(log.is_last_of("/p", as_bytes("new\r\n")));
  EXPECT_FALSE(log.is_last_of("/p", as_bytes("old")));
  EXPECT_FALSE(log.is_last_of("/p", as_bytes("other")));
  EXPECT_FALSE(log.is_last_of("/r", as_bytes("new\n")));
}

TEST(SigningLog, ALineThatCannotBeRead_CountsForNothingAndIsTold) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto good = line("a", c, "/p");
  for (const auto& bad : {std::string(), std::string("[]"), std::string("nonsense"),
                          std::string(kMaxLogLineOctets + 1, ' '),
                          std::string(R"({"event":"signed","sha256":"00","ca":"00","file":"/p"})"),
                          std::string(R"({"event":"issued","serial":"0A"})")}) {
    const auto log = SigningLog::parse(as_bytes(good + bad + "\n" + line("b", c, "/q")));
    EXPECT_EQ(log.unreadable(), std::vector{2}) << bad;
    EXPECT_EQ(log.standing(as_bytes("a"), c), Standing::current) << bad;
    EXPECT_EQ(log.standing(as_bytes("b"), c), Standing::current) << bad;
  }
}

TEST(SigningLog, ALastLineCutShortAtAnyOctet_CountsForNothing) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  const auto second = line("b", c, "/p");
  for (std::size_t size = 1; size + 1 < second.size(); ++size) {
    const auto log = SigningLog::parse(as_bytes(line("a", c, "/p") + second.substr(0, size)));
    EXPECT_EQ(log.unreadable(), std::vector{2}) << size;
    EXPECT_EQ(log.standing(as_bytes("a"), c), Standing::current) << size;
    EXPECT_EQ(log.standing(as_bytes("b"), c), Standing::unknown) << size;
  }
}

TEST(SigningLog, LastLineWithoutLineEnd_Counts) {
  const auto ca = make_ca();
  const auto& c = ca.certificate();
  auto text = line("a", c, "/p") + line("b", c, "/p");
  text.pop_back();
  const auto log = SigningLog::parse(as_bytes(text));
  EXPECT_TRUE(log.unreadable().empty());
  EXPECT_EQ(log.standing(as_bytes("a"), c), Standing::superseded);
  EXPECT_EQ(log.standing(as_bytes("b"), c), Standing::current);
}

}  // namespace
}  // namespace ddssec::pki
