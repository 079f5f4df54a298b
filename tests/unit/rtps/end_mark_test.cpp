// The mark of payloads that end an instance.
#include "rtps/reliability/end_mark.hpp"

#include <set>

#include <gtest/gtest.h>

#include "rtps/cdr/encapsulation.hpp"

namespace ddssec::rtps {
namespace {

TEST(EndMark, EachEnd_HasItsOwn) {
  std::set<std::uint8_t> marks;
  for (const bool disposed : {false, true})
    for (const bool unregistered : {false, true})
      for (const bool is_key : {false, true})
        marks.insert(end_mark({disposed, unregistered}, is_key));
  EXPECT_EQ(marks.size(), 7u) << "the first two are alive";
  EXPECT_EQ(end_mark({.filtered = true}, false), 0);
}

TEST(EndMark, MarkedPayload_HasTheMarkThatWasSet) {
  Bytes payload = {0, 1, 0, 2, 5, 6, 0, 0};
  const auto mark = end_mark({true, false}, true);
  EXPECT_TRUE(has_end_mark(payload, 0));
  set_end_mark(payload, mark);
  EXPECT_TRUE(has_end_mark(payload, mark));
  EXPECT_FALSE(has_end_mark(payload, 0));
  const auto opened = open_payload(payload);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->body.size(), 2u) << "the padding is still counted";
  set_end_mark(payload, 0);
  EXPECT_EQ(payload, (Bytes{0, 1, 0, 2, 5, 6, 0, 0}));
}

TEST(EndMark, PayloadThatIsTooShort_EndsNothing) {
  Bytes payload = {0, 1};
  set_end_mark(payload, 0x81);
  EXPECT_EQ(payload, (Bytes{0, 1}));
  EXPECT_TRUE(has_end_mark(payload, 0));
  EXPECT_FALSE(has_end_mark({}, 0x81));
}

}  // namespace
}  // namespace ddssec::rtps
