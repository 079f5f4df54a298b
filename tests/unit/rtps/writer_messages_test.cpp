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

// Protects payloads without changing them, and counts them.
struct Counting final : SendProtection {
  Levels levels(const EntityId&) const override { return {.payload = true}; }
  Result<std::size_t> protect_payload(const EntityId&, BytesView plain, MutableBytes out) override {
    ++payloads;
    std::ranges::copy(plain, out.begin());
    return plain.size();
  }
  Result<std::size_t> protect_submessage(const EntityId&, const Guid&, BytesView,
                                         MutableBytes) override {
    return fail(Code::malformed);
  }
  Result<std::size_t> protect_message(Wrap, const GuidPrefix&, BytesView, MutableBytes) override {
    return fail(Code::malformed);
  }
  void on_unprotectable(const Error&) override {}
  int payloads = 0;
};

// A participant that anyone can announce must not make us encrypt what is never sent.
TEST_F(WriterParts, LimitedReaderWithoutCredit_CostsNoSerialization) {
  Counting counting;
  sender.protect_with(counting);
  sender.fragment_at(1'000);
  auto& limit = sender.amplification_limit();
  const LocatorList at{kHere};
  const std::vector sources{SourceAddress(kHere)};
  limit.begin(guid(1).prefix, at, sources);
  const auto credit = [&](std::size_t octets) {
    limit.begin_datagram(sources[0], octets);
    limit.add_credit(guid(1).prefix);
  };
  MatchedReaders limited{testing::kWriter, true, &limit};
  auto& proxy = limited.add({guid(1), true, false, {kHere}}, {{1}});
  credit(100);
  messages.change(limited.one(proxy), add(1'000'000));
  EXPECT_EQ(counting.payloads, 0);
  EXPECT_THAT(said(), ElementsAre());
  credit(1'000);
  messages.change(limited.one(proxy), *history.find({1}));
  EXPECT_EQ(counting.payloads, 3);
  EXPECT_THAT(said(), ElementsAre("fragment 1", "fragment 2", "fragment 3"));
  limit.end(guid(1).prefix);
  messages.change(limited.one(proxy), *history.find({1}));
  EXPECT_EQ(counting.payloads, 1'003);
}

TEST_F(WriterParts, Heartbeats_AreCounted) {
  add();
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  for (int i = 0; i < 3; ++i) messages.heartbeat(readers.one(proxy), {1}, {.is_final = true});
  EXPECT_THAT(said(), ElementsAre("heartbeat", "heartbeat", "heartbeat"));
}

}  // namespace
}  // namespace ddssec::rtps::writer_parts
