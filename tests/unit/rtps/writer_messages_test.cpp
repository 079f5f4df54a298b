// What a writer sends: changes in fragments, and counted HEARTBEATs.
#include "rtps/reliability/writer_messages.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/stateful_writer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps/writer_parts.hpp"

namespace ddssec::rtps::writer_parts {
namespace {

using ::testing::ElementsAre;

const Locator kHere = *Locator::parse("127.0.0.1", 1);

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

TEST_F(WriterParts, LargeChanges_GoInFragments) {
  sender.fragment_at(1'000);
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  messages.change(readers.one(proxy), add(1'000));
  EXPECT_THAT(said(), ElementsAre("data 1"));
  messages.change(readers.one(proxy), add(2'001));
  EXPECT_THAT(said(), ElementsAre("fragment 1", "fragment 2", "fragment 3"));
  messages.change(readers.one(proxy), *history.find({2}), {}, 1);
  EXPECT_THAT(said(), ElementsAre("fragment 1"));
}

TEST_F(WriterParts, Heartbeats_AreCounted) {
  add();
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  for (int i = 0; i < 3; ++i) messages.heartbeat(readers.one(proxy), {1}, {.is_final = true});
  EXPECT_THAT(said(), ElementsAre("heartbeat", "heartbeat", "heartbeat"));
}

}  // namespace
}  // namespace ddssec::rtps::writer_parts
