// A renewal list that is replaced while a participant runs.
#include "pki/renewal_list_watch.hpp"

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

using testing::ElementsAre;
using testing::UnorderedElementsAre;

class RenewalListWatchTest : public testing::Test {
 protected:
  static Certificate leaf(const std::string& subject) {
    static const auto ca = make_ca("CN=CA");
    return make_leaf(ca, "CN=" + subject).certificate;
  }
  static Bytes permissions(std::string_view text) { return to_bytes(as_bytes(text)); }
  void write(const RenewalList& list) { folder_.write("renewed.pem", list.text().value()); }
  Result<bool> poll() {
    now_ += 1s;
    return watch_.poll(now_, [&](const RenewalList& list) -> Status {
      in_force_ = list;
      return {};
    });
  }

  const test::TemporaryFolder folder_;
  RenewalListWatch watch_{
      {"file:" + folder_.path() + "/renewed.pem"}, 1s, Code::renewal_list_refused};
  std::chrono::nanoseconds now_{0};
  RenewalList in_force_;
  const Certificate one_ = leaf("one"), two_ = leaf("two");
  const Bytes first_ = permissions("first"), second_ = permissions("second");
};

TEST_F(RenewalListWatchTest, ListCutBetweenItsEntries_LosesNone) {
  const RenewalList whole{{one_, two_}, {first_, second_}};
  write(whole);
  EXPECT_EQ(poll(), true);
  for (const auto& cut : {RenewalList{{one_}, {}}, RenewalList{{one_, two_}, {}},
                          RenewalList{{one_, two_}, {first_}}}) {
    write(cut);
    EXPECT_EQ(poll(), false);
    EXPECT_THAT(in_force_.certificates, UnorderedElementsAre(one_, two_));
    EXPECT_THAT(in_force_.permissions, UnorderedElementsAre(first_, second_));
    write(whole);
    EXPECT_EQ(poll(), true);
  }
  EXPECT_FALSE(watch_.refused());
}

TEST_F(RenewalListWatchTest, ListWithFewerEntries_CountsAtTheSecondLook) {
  write({{one_, two_}, {first_}});
  poll();
  write({{two_}, {}});
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(poll(), true);
  EXPECT_THAT(in_force_.certificates, ElementsAre(two_));
  EXPECT_TRUE(in_force_.permissions.empty());
  EXPECT_EQ(poll(), false);
}

TEST_F(RenewalListWatchTest, NewEntriesOfAShorterList_CountAtOnce) {
  write({{one_}, {first_}});
  poll();
  write({{two_}, {second_}});
  EXPECT_EQ(poll(), false);
  EXPECT_THAT(in_force_.certificates, UnorderedElementsAre(one_, two_));
  EXPECT_THAT(in_force_.permissions, UnorderedElementsAre(first_, second_));
}

TEST_F(RenewalListWatchTest, LaterCertificateOfASubject_ReplacesTheFormerAtOnce) {
  write({{one_}, {}});
  poll();
  const auto later = leaf("one");
  write({{later}, {}});
  EXPECT_EQ(poll(), true);
  EXPECT_THAT(in_force_.certificates, ElementsAre(later));
}

TEST_F(RenewalListWatchTest, FormerListAfterAnUndecidedOne_IsJudged) {
  write({{one_}, {}});
  poll();
  write({{two_}, {}});
  poll();
  write({{one_}, {}});
  EXPECT_EQ(poll(), false);
  EXPECT_EQ(poll(), true);
  EXPECT_THAT(in_force_.certificates, ElementsAre(one_));
}

}  // namespace
}  // namespace ddssec::pki
