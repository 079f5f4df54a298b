#include "base/documents_in_use.hpp"

#include <array>
#include <sys/wait.h>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace ddssec {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

constexpr WallTime kNow{1'800'000'000s};

DocumentState state(std::string number, std::optional<Error> refused = {}) {
  return {.kind = DocumentKind::identity_certificate,
          .file = "/a/cert.pem",
          .parts = {{.subject = "CN=a", .number = std::move(number), .until = kNow + 24h}},
          .refused = std::move(refused)};
}

Error refusal(std::string document = "/a/cert.pem") {
  return Error(Code::identity_renewal_refused,
               {.document = std::move(document), .expected = "CN=a", .found = "CN=b"});
}

struct DocumentsInUseTest : testing::Test {
  DocumentsInUseTest() { documents.note_participant(1, "0110", "CN=a"); }
  json answer() const { return json::parse(documents.to_json()); }
  json first() const { return answer()["participants"][0]["documents"][0]; }
  void note(const DocumentState& one, std::chrono::seconds later = 0s) {
    documents.note(1, {one}, kNow + later);
  }
  DocumentsInUse documents;
};

TEST_F(DocumentsInUseTest, ParticipantThatIsCutOff_HasTheFirstReason) {
  note(state("7"));
  EXPECT_TRUE(answer()["participants"][0]["cut_off"].is_null());
  documents.note_end(2, Error(Code::certificate_expired), kNow);
  documents.note_end(1, Error(Code::certificate_revoked), kNow);
  documents.note_end(1, Error(Code::certificate_expired), kNow + 1s);
  const auto end = answer()["participants"][0]["cut_off"];
  EXPECT_EQ(end["name"], "certificate_revoked");
  EXPECT_EQ(end["at"], to_string(kNow));
  EXPECT_EQ(answer()["participants"].size(), 1u);
}

TEST_F(DocumentsInUseTest, Document_IsShownWithItsPartsAndSinceWhen) {
  note(state("7"));
  const auto all = answer();
  EXPECT_EQ(all["schema"], "ddssec-status/1");
  EXPECT_EQ(all["pid"], ::getpid());
  EXPECT_EQ(all["left_out"], 0);
  EXPECT_EQ(all["participants"][0]["guid"], "0110");
  EXPECT_EQ(all["participants"][0]["subject"], "CN=a");
  const auto document = first();
  EXPECT_EQ(document["kind"], "identity certificate");
  EXPECT_EQ(document["file"], "/a/cert.pem");
  EXPECT_EQ(document["since"], to_string(kNow));
  EXPECT_EQ(document["in_force"][0]["number"], "7");
  EXPECT_EQ(document["in_force"][0]["until"], to_string(kNow + 24h));
  EXPECT_TRUE(document["refused"].is_null());
  EXPECT_TRUE(document["waiting"].is_null());
}

TEST_F(DocumentsInUseTest, DocumentThatWaits_IsShownUntilItWaitsNoMore) {
  auto waits = state("7");
  waits.waiting = DocumentPart{.subject = "revision 8", .sha256 = "08"};
  note(waits);
  EXPECT_EQ(first()["waiting"]["subject"], "revision 8");
  EXPECT_EQ(first()["in_force"][0]["number"], "7");
  note(state("7"), 10s);
  EXPECT_TRUE(first()["waiting"].is_null());
  EXPECT_EQ(first()["since"], to_string(kNow));
}

TEST_F(DocumentsInUseTest, StateOfTheFile_IsShown) {
  auto one = state("7");
  for (const auto is : {FileState::current, FileState::candidate, FileState::refused}) {
    one.state = is;
    note(one);
    EXPECT_EQ(first()["state"], to_string(is));
  }
  one.waiting = DocumentPart{.subject = "revision 8"};
  note(one);
  EXPECT_EQ(first()["state"], "refused") << "another file came while the former one waits";
  one.state = FileState::current;
  note(one);
  EXPECT_EQ(first()["state"], "candidate");
}

TEST_F(DocumentsInUseTest, SameStateAgain_KeepsItsTime) {
  note(state("7"));
  note(state("7"), 60s);
  EXPECT_EQ(first()["since"], to_string(kNow));
  note(state("8"), 120s);
  EXPECT_EQ(first()["since"], to_string(kNow + 120s));
  EXPECT_EQ(first()["in_force"][0]["number"], "8");
}

TEST_F(DocumentsInUseTest, Refusal_HasItsSentenceAndTimeAndKeepsWhatIsInForce) {
  note(state("7"));
  const auto error = refusal();
  note(state("7", error), 10s);
  note(state("7", error), 20s);
  const auto refused = first()["refused"];
  EXPECT_EQ(refused["at"], to_string(kNow + 10s));
  EXPECT_EQ(refused["file"], "/a/cert.pem");
  EXPECT_EQ(refused["code"], static_cast<int>(Code::identity_renewal_refused));
  EXPECT_EQ(refused["name"], "identity_renewal_refused");
  EXPECT_EQ(refused["sentence"], error.to_sentence());
  EXPECT_EQ(refused["stands"], true);
  EXPECT_EQ(first()["since"], to_string(kNow));
}

TEST_F(DocumentsInUseTest, RefusalThatNoLongerHolds_StaysKnown) {
  note(state("7", refusal()));
  note(state("8"), 5s);
  EXPECT_EQ(first()["refused"]["stands"], false);
  EXPECT_EQ(first()["refused"]["at"], to_string(kNow));
  note(state("8", refusal("/a/key.pem")), 9s);
  EXPECT_EQ(first()["refused"]["stands"], true);
  EXPECT_EQ(first()["refused"]["at"], to_string(kNow + 9s));
  EXPECT_EQ(first()["refused"]["file"], "/a/key.pem");
}

TEST_F(DocumentsInUseTest, ForgottenKinds_LeaveAndTheParticipantWithTheLast) {
  note(state("7"));
  auto ca = state("9");
  ca.kind = DocumentKind::permissions_ca;
  note(ca);
  documents.forget(1, std::array{DocumentKind::permissions_ca});
  EXPECT_EQ(answer()["participants"][0]["documents"].size(), 1u);
  documents.forget(1, std::array{DocumentKind::identity_certificate});
  EXPECT_TRUE(answer()["participants"].empty());
  note(state("7"));
  EXPECT_TRUE(answer()["participants"].empty()) << "it has left";
}

TEST_F(DocumentsInUseTest, ManyPartsAndLongTexts_AreBounded) {
  auto one = state("7");
  one.file = std::string(100'000, 'f');
  one.parts.assign(256, {.subject = std::string(100'000, 's')});
  note(one);
  EXPECT_EQ(first()["in_force"].size(), DocumentsInUse::kMaxParts);
  EXPECT_EQ(first()["more"], 240);
  EXPECT_LT(documents.to_json().size(), 64'000u);
}

TEST_F(DocumentsInUseTest, ManyParticipants_AreCountedWhereTheyDoNotFit) {
  auto one = state("7");
  one.parts.assign(16, {.subject = std::string(1000, 's')});
  for (int i = 1; i <= 256; ++i) {
    documents.note_participant(i, "", "CN=a");
    documents.note(i, {one}, kNow);
  }
  const auto all = answer();
  EXPECT_EQ(all["participants"].size() + all["left_out"].get<std::size_t>(), 256u);
  EXPECT_GT(all["left_out"], 0);
  EXPECT_LT(documents.to_json().size(), DocumentsInUse::kMaxOctets + 100'000);
}

TEST_F(DocumentsInUseTest, OctetsThatAreNoUtf8_AreReplaced) {
  documents.note_participant(1, "", "CN=\xff\x1b[2J");
  const auto text = documents.to_json();
  EXPECT_EQ(text.find('\x1b'), text.npos);
  EXPECT_TRUE(json::accept(text));
}

TEST_F(DocumentsInUseTest, ChildOfAFork_NotesNothing) {
  note(state("7"));
  const auto child = ::fork();
  if (child == 0) {
    note(state("8"));
    ::_exit(first()["in_force"][0]["number"] == "7" ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
}

}  // namespace
}  // namespace ddssec
