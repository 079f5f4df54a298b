// A CA file that is replaced while a participant runs.
#include "pki/authority_watch.hpp"

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

class AuthorityWatchTest : public testing::Test {
 protected:
  using Authorities = AuthorityWatch::Authorities;
  static std::string pem(const Authorities& all) {
    std::string out;
    for (const auto& one : all) out += one.pem();
    return out;
  }
  void write_in_place(const std::string& text) { folder_.write("ca.pem", text); }
  void put(const Authorities& all) { folder_.replace("ca.pem", pem(all)); }
  Result<bool> poll(Status answer = {}) {
    now_ += 5s;
    const auto former = in_force_;
    return watch_.poll(now_, former, [&](const Authorities& next) -> Status {
      ++judged_;
      if (answer) in_force_ = next;
      return answer;
    });
  }

  const Certificate one_ = make_ca("CN=One").certificate(), two_ = make_ca("CN=Two").certificate();
  Authorities in_force_ = {one_, two_};
  const test::TemporaryFolder folder_;
  AuthorityWatch watch_{{.uri = "file:" + folder_.write("ca.pem", pem(in_force_)),
                         .name = "the.property",
                         .max_octets = 0,
                         .refused = Code::identity_renewal_refused,
                         .stays = "the former CAs stay"},
                        5s};
  std::chrono::nanoseconds now_{0};
  int judged_ = 0;
};

TEST_F(AuthorityWatchTest, SameAuthoritiesInAnotherOrder_AreNoChange) {
  EXPECT_EQ(poll(), false);
  put({two_, one_});
  EXPECT_EQ(poll(), false);
  put({two_, one_, one_});
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(judged_, 0);
}

TEST_F(AuthorityWatchTest, AddedAndRemovedAuthorities_AreTaken) {
  const auto three = make_ca("CN=Three").certificate();
  put({one_, two_, three});
  EXPECT_EQ(poll(), true);
  put({three});
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(poll(), true);
  EXPECT_EQ(in_force_, Authorities{three});
  EXPECT_EQ(judged_, 2);
}

TEST_F(AuthorityWatchTest, RemovedAuthority_DoesNotComeBack) {
  put({two_});
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(poll(), true);
  put({one_, two_});
  EXPECT_EQ(poll(), false);
  const auto refused = poll();
  EXPECT_CODE(refused, identity_renewal_refused);
  EXPECT_NE(refused.error().details().note.find(info(Code::ca_put_back).summary),
            std::string::npos);
  EXPECT_EQ(in_force_, Authorities{two_});
  EXPECT_EQ(judged_, 1);
  ASSERT_TRUE(watch_.refused());
}

TEST_F(AuthorityWatchTest, RefusedAuthorities_AreNotWithdrawnAndReported) {
  put({two_});
  EXPECT_EQ(poll(fail(Code::malformed)), false);
  EXPECT_EQ(judged_, 0);
  EXPECT_CODE(poll(fail(Code::malformed)), identity_renewal_refused);
  put({one_, two_});
  EXPECT_EQ(poll(), false);
  EXPECT_FALSE(watch_.refused());
}

// ---- a file that is being written

TEST_F(AuthorityWatchTest, FileCutBetweenItsCertificates_LosesNoCa) {
  for (const auto& first : {one_, two_}) {
    write_in_place(first.pem());
    EXPECT_EQ(poll(), false);
    write_in_place(pem({one_, two_}));
    EXPECT_EQ(poll(), false);
  }
  EXPECT_EQ(judged_, 0);
  EXPECT_FALSE(watch_.refused());
}

TEST_F(AuthorityWatchTest, FileCutAtTwoPollsThatAreNotInARow_LosesNoCa) {
  for (int i = 0; i < 4; ++i) {
    write_in_place(i % 2 == 0 ? one_.pem() : pem({one_, two_}));
    EXPECT_EQ(poll(), false);
  }
  write_in_place("-----BEGIN");
  EXPECT_EQ(poll(), false);
  write_in_place(one_.pem());
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(judged_, 0);
}

TEST_F(AuthorityWatchTest, FileThatGrows_LosesNoCa) {
  const auto three = make_ca("CN=Three").certificate();
  in_force_ = {one_, two_, three};
  write_in_place(one_.pem());
  EXPECT_EQ(poll(), false);
  write_in_place(pem({one_, two_}));
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(judged_, 0);
}

TEST_F(AuthorityWatchTest, WriterThatPausesLonger_BringsTheCaBack) {
  write_in_place(two_.pem());
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(poll(), true) << "a stolen CA must end";
  write_in_place(pem({two_, one_}));
  EXPECT_EQ(poll(), true);
  EXPECT_EQ(in_force_, (Authorities{two_, one_}));
}

TEST_F(AuthorityWatchTest, FileThatGoesOnWithAnotherCa_KeepsTheOneThatLeftWithdrawn) {
  const auto three = make_ca("CN=Three").certificate();
  write_in_place(two_.pem());
  poll();
  EXPECT_EQ(poll(), true) << "CN=One was withdrawn";
  write_in_place(pem({two_, three}));
  EXPECT_EQ(poll(), true);
  put({one_, two_});
  poll();
  EXPECT_CODE(poll(), identity_renewal_refused);
  EXPECT_EQ(in_force_, (Authorities{two_, three}));
}

TEST_F(AuthorityWatchTest, WriterThatPausesTwice_BringsEachCaBack) {
  const auto three = make_ca("CN=Three").certificate();
  in_force_ = {one_, two_, three};
  write_in_place(two_.pem());
  poll();
  EXPECT_EQ(poll(), true);
  write_in_place(pem({two_, three}));
  EXPECT_EQ(poll(), true);
  write_in_place(pem({two_, three, one_}));
  EXPECT_EQ(poll(), true);
  EXPECT_EQ(in_force_, (Authorities{two_, three, one_}));
}

// An attacker could do these.
TEST_F(AuthorityWatchTest, FileThatIsNoContinuation_BringsNoCaBack) {
  write_in_place(two_.pem());
  poll();
  EXPECT_EQ(poll(), true);
  write_in_place(pem({one_, two_}));
  EXPECT_EQ(poll(), false) << "other octets at the beginning";
  put({two_, one_});
  EXPECT_CODE(poll(), identity_renewal_refused);
  EXPECT_EQ(in_force_, Authorities{two_});
}

TEST_F(AuthorityWatchTest, FileThatWasRenamedIntoPlace_IsNotContinued) {
  put({two_});
  poll();
  EXPECT_EQ(poll(), true);
  write_in_place(pem({two_, one_}));
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(in_force_, Authorities{two_});
}

TEST_F(AuthorityWatchTest, FormerFileAfterAnotherOne_IsNotContinued) {
  const auto path = folder_.path() + "/ca.pem";
  std::filesystem::create_hard_link(path, path + ".kept");
  write_in_place(two_.pem());
  poll();
  EXPECT_EQ(poll(), true);
  put({two_});
  EXPECT_EQ(poll(), false);
  folder_.write("ca.pem.kept", pem({two_, one_}));
  std::filesystem::rename(path + ".kept", path);
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(in_force_, Authorities{two_});
}

TEST_F(AuthorityWatchTest, ContinuationThatComesTooLate_BringsNoCaBack) {
  write_in_place(two_.pem());
  poll();
  EXPECT_EQ(poll(), true);
  now_ += AuthorityWatch::kMaxWritingTime;
  write_in_place(pem({two_, one_}));
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(in_force_, Authorities{two_});
}

TEST_F(AuthorityWatchTest, FileWithoutACertificate_IsReported) {
  folder_.replace("ca.pem", "nonsense");
  EXPECT_EQ(poll(), false);
  EXPECT_CODE(poll(), identity_renewal_refused);
  EXPECT_EQ(judged_, 0);
}

}  // namespace
}  // namespace ddssec::pki
