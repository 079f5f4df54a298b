// A document that is replaced while a participant runs.
#include "base/document_watch.hpp"

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

using namespace std::chrono_literals;

class DocumentWatchTest : public testing::Test {
 protected:
  DocumentWatch watch_of(std::string uri, bool gives_remedy = false) const {
    return DocumentWatch({.uri = std::move(uri),
                          .name = "the.property",
                          .max_octets = 100,
                          .refused = Code::permissions_renewal_refused,
                          .stays = "the former stays",
                          .gives_remedy_of_reason = gives_remedy},
                         5s);
  }
  DocumentWatch watch_of_file() const {
    auto out = watch_of("file:" + path_);
    out.note_read(as_bytes("first"));
    return out;
  }
  // Polls at the time of the next look. The document is adopted unless it is "bad".
  Result<bool> poll(DocumentWatch& watch) {
    now_ += 5s;
    return watch.poll(now_, [&](BytesView octets) -> Status {
      taken_.emplace_back(as_text(octets));
      if (as_text(octets) == "bad") return fail(Code::malformed, {.hint = "write it anew"});
      return {};
    });
  }

  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.write("document", "first");
  std::chrono::nanoseconds now_{0};
  std::vector<std::string> taken_;
};

TEST_F(DocumentWatchTest, SameContentWrittenAgain_IsNotTaken) {
  auto watch = watch_of_file();
  EXPECT_EQ(poll(watch), false);
  folder_.replace("document", "first");
  EXPECT_EQ(poll(watch), false);
  EXPECT_TRUE(taken_.empty());
}

TEST_F(DocumentWatchTest, OtherContent_IsTakenOnce) {
  auto watch = watch_of_file();
  folder_.replace("document", "second");
  EXPECT_EQ(poll(watch), true);
  EXPECT_EQ(poll(watch), false);
  EXPECT_EQ(taken_, std::vector<std::string>{"second"});
}

TEST_F(DocumentWatchTest, RefusedDocument_IsReportedAtTheSecondLookAndOnce) {
  auto watch = watch_of_file();
  folder_.replace("document", "bad");
  EXPECT_EQ(poll(watch), false) << "it may be in the middle of a write";
  const auto told = poll(watch);
  EXPECT_CODE(told, permissions_renewal_refused);
  EXPECT_EQ(told.error().details().document, path_);
  EXPECT_TRUE(told.error().details().note.ends_with("the former stays"));
  EXPECT_EQ(told.error().hint(), info(Code::permissions_renewal_refused).hint);
  EXPECT_EQ(watch.refused()->code(), Code::permissions_renewal_refused);
  EXPECT_EQ(poll(watch), false);
  EXPECT_EQ(taken_.size(), 3u)
      << "a refused document is judged again: what it depends on may change";
  folder_.replace("document", "good");
  EXPECT_EQ(poll(watch), true);
  EXPECT_FALSE(watch.refused());
}

TEST_F(DocumentWatchTest, DocumentThatIsRefusedAndPutBack_IsNotTaken) {
  auto watch = watch_of_file();
  folder_.replace("document", "bad");
  EXPECT_EQ(poll(watch), false);
  folder_.replace("document", "first");
  EXPECT_EQ(poll(watch), false);
  EXPECT_EQ(taken_, std::vector<std::string>{"bad"});
}

TEST_F(DocumentWatchTest, DocumentThatIsUndecided_IsJudgedAgainAtTheNextPoll) {
  auto watch = watch_of_file();
  poll(watch);
  std::vector<bool> known;
  const auto poll_undecided = [&] {
    now_ += 5s;
    return watch.poll(now_, [&](BytesView) -> Status {
      known.push_back(watch.is_as_at_last_poll());
      if (!known.back()) watch.decide_at_next_poll();
      return {};
    });
  };
  folder_.replace("document", "second");
  EXPECT_EQ(poll_undecided(), false);
  folder_.replace("document", "third");
  EXPECT_EQ(poll_undecided(), false);
  EXPECT_EQ(poll_undecided(), true);
  EXPECT_EQ(known, (std::vector{false, false, true}));
}

TEST_F(DocumentWatchTest, RefusalAfterAnUndecidedPoll_IsTheSecond) {
  auto watch = watch_of_file();
  poll(watch);
  folder_.replace("document", "bad");
  now_ += 5s;
  EXPECT_EQ(watch.poll(now_,
                       [&](BytesView) -> Status {
                         watch.decide_at_next_poll();
                         return {};
                       }),
            false);
  EXPECT_CODE(poll(watch), permissions_renewal_refused);
}

TEST_F(DocumentWatchTest, RemedyOfTheReason_IsGivenIfTheDocumentMustBeWrittenAnew) {
  auto watch = watch_of("file:" + path_, true);
  folder_.replace("document", "bad");
  EXPECT_EQ(poll(watch), false);
  const auto told = poll(watch);
  EXPECT_CODE(told, permissions_renewal_refused);
  EXPECT_EQ(told.error().hint(), "write it anew");
}

TEST_F(DocumentWatchTest, FileThatIsGoneOrTooLarge_IsReported) {
  auto watch = watch_of_file();
  std::filesystem::remove(path_);
  EXPECT_EQ(poll(watch), false);
  const auto gone = poll(watch);
  EXPECT_CODE(gone, permissions_renewal_refused);
  folder_.write("document", std::string(101, 'x'));
  const auto large = poll(watch);
  EXPECT_CODE(large, permissions_renewal_refused);
  EXPECT_NE(large.error().details().note.find(info(Code::file_too_large).summary),
            std::string::npos);
  EXPECT_TRUE(taken_.empty());
}

TEST_F(DocumentWatchTest, LookBeforeTheInterval_ReadsNothingUnlessAskedTo) {
  auto watch = watch_of_file();
  poll(watch);
  poll(watch);
  folder_.replace("document", "second");
  now_ -= 4s;
  EXPECT_EQ(poll(watch), false);
  now_ -= 5s;
  watch.force_poll();
  EXPECT_EQ(poll(watch), true);
}

TEST_F(DocumentWatchTest, DocumentInTheProperty_HasThePropertysNameAndNeverChanges) {
  auto watch = watch_of("data:,text");
  EXPECT_EQ(watch.name(), "the.property");
  EXPECT_EQ(as_text(watch.read().value()), "text");
  EXPECT_EQ(poll(watch), false);
  EXPECT_TRUE(taken_.empty());
}

}  // namespace
}  // namespace ddssec
