#include "pki/issue_log.hpp"

#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

TEST(IssueLog, EachLine_SaysWhatWasIssuedAndRevoked) {
  const auto ca = make_ca();
  const auto a = make_leaf(ca, "CN=a").certificate;
  const auto b = make_leaf(ca, "CN=b").certificate;
  const Revocation gone{b.serial(), kNow + 1h, RevocationReason::key_compromise};
  const Revocation foreign{"0A", kNow, RevocationReason::superseded};
  const auto text = IssueLog::issued_line(a, "/fleet/a", kNow) +
                    IssueLog::issued_line(b, "", kNow) + IssueLog::revoked_line(gone) +
                    IssueLog::revoked_line(foreign);
  const auto log = IssueLog::parse(as_bytes(text));
  ASSERT_TRUE(log.unreadable().empty());
  ASSERT_EQ(log.issued().size(), 2u);
  const auto* found = log.find(a.serial());
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->subject, "CN=a");
  EXPECT_EQ(found->folder, "/fleet/a");
  EXPECT_EQ(found->not_after, a.not_after());
  EXPECT_FALSE(found->revoked);
  EXPECT_EQ(log.find(b.serial())->revoked, gone);
  EXPECT_TRUE(log.is_revoked("0A"));
  EXPECT_FALSE(log.is_revoked(a.serial()));
  EXPECT_EQ(log.find("0A"), nullptr);
  EXPECT_EQ(log.revocations().size(), 2u);
  EXPECT_EQ(log.places(), std::vector<std::string>{"/fleet/a"});
}

TEST(IssueLog, EachLine_SaysWhatACertificateIsAndWhichKeyItHas) {
  const auto ca = make_ca();
  const auto first = make_leaf(ca, "CN=a");
  const auto other = make_leaf(ca, "CN=a");
  const auto log = IssueLog::parse(as_bytes(IssueLog::issued_line(first.certificate, "/a", kNow)));
  ASSERT_TRUE(log.unreadable().empty());
  const auto& issued = log.issued().front();
  EXPECT_EQ(issued.sha256, to_hex(first.certificate.fingerprint()));
  EXPECT_EQ(issued.key, key_digest(first.certificate));
  EXPECT_EQ(issued.key.size(), 64u);
  EXPECT_NE(issued.key, key_digest(other.certificate));
  EXPECT_NE(issued.key, key_digest(ca.certificate()));
}

TEST(IssueLog, RevokedCertificates_AreKnownByTheirKeys) {
  const auto ca = make_ca();
  const auto logged = make_leaf(ca, "CN=a").certificate;
  const auto foreign = make_leaf(ca, "CN=b").certificate;
  const auto good = make_leaf(ca, "CN=c").certificate;
  const auto text = IssueLog::issued_line(logged, "", kNow) +
                    IssueLog::issued_line(good, "", kNow) +
                    IssueLog::revoked_line({logged.serial(), kNow, {}}) +
                    IssueLog::revoked_line({"0A", kNow, {}}) +  // logged before keys were logged
                    IssueLog::revoked_line({"0A", kNow, {}}, key_digest(foreign));
  const auto log = IssueLog::parse(as_bytes(text));
  ASSERT_TRUE(log.unreadable().empty());
  EXPECT_EQ(log.revoked_serial(KeyDigests(logged)), logged.serial());
  EXPECT_EQ(log.revoked_serial(KeyDigests(foreign)), "0A");
  EXPECT_EQ(log.revoked_serial(KeyDigests(good)), "");
  EXPECT_EQ(log.revocations().size(), 2u);
}

TEST(IssueLog, ALastLineCutShortAtAnyOctet_CountsForNothing) {
  const auto ca = make_ca();
  const auto first = IssueLog::issued_line(make_leaf(ca, "CN=a").certificate, "", kNow);
  const auto second = IssueLog::issued_line(make_leaf(ca, "CN=b").certificate, "", kNow);
  for (std::size_t size = 1; size + 1 < second.size(); ++size) {
    const auto log = IssueLog::parse(as_bytes(first + second.substr(0, size)));
    ASSERT_EQ(log.unreadable().size(), 1u) << size;
    EXPECT_EQ(log.unreadable()[0].details().line, 2) << size;
    EXPECT_EQ(log.issued().size(), 1u) << size;
  }
  EXPECT_TRUE(IssueLog::parse(as_bytes(first)).unreadable().empty());
  EXPECT_TRUE(IssueLog::parse({}).issued().empty());
}

TEST(IssueLog, LastLineWithoutLineEnd_Counts) {
  const auto line = IssueLog::revoked_line({"0A", kNow, RevocationReason::key_compromise});
  const auto log = IssueLog::parse(as_bytes(line.substr(0, line.size() - 1)));
  EXPECT_TRUE(log.unreadable().empty());
  EXPECT_TRUE(log.is_revoked("0A"));
}

TEST(IssueLog, TheFirstLineOfASerialNumber_Counts) {
  const Revocation first{"0A", kNow, RevocationReason::key_compromise};
  const Revocation second{"0A", kNow + 1h, RevocationReason::unspecified};
  const auto text = IssueLog::revoked_line(first) + IssueLog::revoked_line(second);
  EXPECT_EQ(IssueLog::parse(as_bytes(text)).revocations(), std::vector{first});
}

std::string line_of(const std::string& serial, const std::string& sha256, const std::string& key,
                    const std::string& folder) {
  return R"({"event":"issued","time":"2026-11-21T00:00:00Z","serial":")" + serial +
         R"(","subject":"CN=a","not_after":"2027-11-21T00:00:00Z","sha256":")" + sha256 +
         R"(","key":")" + key + R"(","folder":")" + folder + "\"}\n";
}

TEST(IssueLog, ACertificateThatWasMoved_IsInItsLastPlace) {
  const auto line = [](const std::string& sha256, const std::string& folder) {
    return line_of("0A", sha256, "k", folder);
  };
  const auto place = [](const std::string& text) {
    const auto log = IssueLog::parse(as_bytes(text));
    EXPECT_EQ(log.issued().size(), 1u);
    EXPECT_EQ(log.present_places().size(), 1u);
    return log.find("0A")->place();
  };
  EXPECT_EQ(place(line("11", "/a") + line("11", "/b")), "/b");
  EXPECT_EQ(place(line("11", "/a") + line("11", "")), "/a");
  EXPECT_EQ(place(line("11", "/a") + line("22", "/b")), "/a") << "another certificate";
  EXPECT_EQ(place(line("", "/a") + line("", "/b")), "/a") << "perhaps another certificate";
}

TEST(IssueLog, PlacesThatAParticipantHasLeft_AreNotPresent) {
  const auto log =
      IssueLog::parse(as_bytes(line_of("0A", "1", "k", "/a") + line_of("0B", "2", "k", "/b") +
                               line_of("0C", "3", "other", "/c") + line_of("0D", "4", "", "/d")));
  EXPECT_EQ(log.present_places(), (std::unordered_set<std::string>{"/b", "/c", "/d"}));
  EXPECT_EQ(log.places().size(), 4u);
}

TEST(IssueLog, PlacesWithRevokedCertificatesAlone_AreRevokedPlaces) {
  const auto revoked = [](const std::string& serial) {
    return IssueLog::revoked_line({serial, WallTime{}, RevocationReason::unspecified});
  };
  const auto log =
      IssueLog::parse(as_bytes(line_of("0A", "1", "k", "/a") + line_of("0B", "2", "k", "/a") +
                               line_of("0C", "3", "l", "/c") + line_of("0D", "4", "m", "") +
                               revoked("0A") + revoked("0C") + revoked("0D") + revoked("0E")));
  EXPECT_EQ(log.revoked_places(), std::vector<std::string>{"/c"});
  EXPECT_EQ(log.places(), std::vector<std::string>{"/a"});
}

TEST(IssueLog, ADamagedLine_IsToldAndTheOthersCount) {
  const std::string good =
      R"({"event":"revoked","time":"2026-11-21T00:00:00Z","serial":"0A","reason":"superseded"})"
      "\n";
  const std::string other =
      R"({"event":"revoked","time":"2026-11-21T00:00:00Z","serial":"0B","reason":"superseded"})"
      "\n";
  ASSERT_TRUE(IssueLog::parse(as_bytes(good + other)).unreadable().empty());
  for (const std::string bad :
       {"", "[]", "nonsense", "{\"event\":\"issued\"",
        R"({"event":"removed","time":"2026-11-21T00:00:00Z","serial":"0A"})",
        R"({"event":"revoked","time":"2026-11-21T00:00:00Z","serial":"0A","reason":"why not"})",
        R"({"event":"revoked","time":"2026-11-31T00:00:00Z","serial":"0A","reason":"superseded"})",
        R"({"event":"revoked","time":"2026-11-21T25:00:00Z","serial":"0A","reason":"superseded"})",
        R"({"event":"revoked","time":7,"serial":"0A","reason":"superseded"})",
        R"({"event":"revoked","time":"2026-11-21T00:00:00Z","serial":"0a","reason":"superseded"})",
        R"({"event":"issued","serial":"0A","subject":"CN=a"})"}) {
    const auto log = IssueLog::parse(as_bytes(good + bad + "\n" + other));
    ASSERT_EQ(log.unreadable().size(), 1u) << bad;
    EXPECT_EQ(log.unreadable()[0].code(), Code::issue_log_malformed);
    EXPECT_EQ(log.unreadable()[0].details().line, 2) << bad;
    EXPECT_TRUE(log.issued().empty()) << bad;
    EXPECT_TRUE(log.is_revoked("0A")) << bad;
    EXPECT_TRUE(log.is_revoked("0B")) << bad;
  }
}

TEST(IssueLog, ALineLongerThanAny_IsPassedOver) {
  const auto ca = make_ca();
  const auto line = IssueLog::issued_line(make_leaf(ca, "CN=a").certificate, "/a", kNow);
  auto longest = line;
  longest.insert(longest.size() - 2, kMaxLogLineOctets + 1 - longest.size(), ' ');
  EXPECT_EQ(IssueLog::parse(as_bytes(longest)).issued().size(), 1u);
  const auto too_long = longest.substr(0, longest.size() - 2) + " }\n";
  for (const auto& bad :
       {too_long, std::string(100'000, '[') + "\n", std::string(60'000, '[') + "\n"}) {
    const auto log = IssueLog::parse(as_bytes(bad + line));
    EXPECT_EQ(log.issued().size(), 1u);
    EXPECT_EQ(log.unreadable().size(), 1u);
  }
}

}  // namespace
}  // namespace ddssec::pki
