#include "rtps/reliability/local_delivery.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

const GuidPrefix kHere = GuidPrefix::from(Bytes(12, 0xaa));
const Guid kWriter{kHere, testing::kWriter}, kReader{kHere, testing::kReader};

struct Nowhere final : Transport {
  void send(BytesView, std::span<const Locator>) override { ADD_FAILURE() << "a message"; }
};

struct LocalDeliveryTest : ::testing::Test {
  Nowhere nowhere;
  MessageSender sender{nowhere, kHere};
  WriterHistory history{keep_all()};
  MatchedReaders readers{testing::kWriter, true};
  LocalDelivery delivery{kWriter, history, readers};
  std::vector<std::int64_t> taken;
  std::size_t room = 100;
  StatefulReader reader{kReader, true, sender, [this](Change& change) {
                          if (taken.size() >= room) return false;
                          taken.push_back(change.sequence_number.value);
                          return true;
                        }};

  static Qos keep_all() {
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    return qos;
  }
  ReaderProxy& attach(SequenceNumber until = {}) {
    auto& proxy =
        readers.add({.guid = kReader, .is_reliable = true, .is_in_process = true}, {{1}, until});
    proxy.local = &reader;
    return proxy;
  }
  void add(int changes) {
    for (int i = 0; i < changes; ++i) history.add({});
  }
};

TEST_F(LocalDeliveryTest, AnAttachedReader_GetsEachChangeOnce) {
  auto& proxy = attach();
  add(3);
  history.discard({2});
  delivery.offer_to_all();
  delivery.offer_to_all();
  EXPECT_THAT(taken, ElementsAre(1, 3));
  EXPECT_EQ(proxy.acknowledged(), SequenceNumber{3});
}

TEST_F(LocalDeliveryTest, WhatAReaderRefuses_StaysUntilItAsks) {
  auto& proxy = attach();
  room = 1;
  add(3);
  delivery.offer_to_all();
  EXPECT_EQ(proxy.acknowledged(), SequenceNumber{1});
  EXPECT_FALSE(readers.acknowledged().reach({3}));
  room = 100;
  delivery.offer(proxy);
  EXPECT_THAT(taken, ElementsAre(1, 2, 3));
  EXPECT_TRUE(readers.acknowledged().reach({3}));
}

TEST_F(LocalDeliveryTest, AReaderOfHistoryOnly_GetsNothingNew) {
  auto& proxy = attach({3});
  add(4);
  delivery.offer_to_all();
  EXPECT_THAT(taken, ElementsAre(1, 2));
  EXPECT_EQ(proxy.acknowledged(), SequenceNumber{4});
}

TEST_F(LocalDeliveryTest, AReaderThatIsNotAttached_GetsNothing) {
  attach().local = nullptr;
  add(1);
  delivery.offer_to_all();
  delivery.assert_liveliness();
  delivery.detach_all();
  EXPECT_THAT(taken, IsEmpty());
}

TEST_F(LocalDeliveryTest, ALivingWriter_IsHeard) {
  attach();
  std::vector<Guid> heard;
  reader.on_alive([&](const Guid& writer) { heard.push_back(writer); });
  delivery.assert_liveliness();
  EXPECT_THAT(heard, ElementsAre(kWriter));
}

// A reader that has all of the writer's changes also knows the writer's position in its group.
TEST_F(LocalDeliveryTest, TheGroupIsTold_OnceAllIsTaken) {
  WriterGroup group{.current = {7}};
  std::vector<std::int64_t> groups;
  reader.on_group([&](const Guid&, SequenceNumber number) { groups.push_back(number.value); });
  delivery.join(group);
  attach();
  room = 1;
  add(2);
  delivery.offer_to_all();
  EXPECT_THAT(groups, IsEmpty());
  room = 2;
  delivery.offer_to_all();
  EXPECT_THAT(groups, ElementsAre(7));
}

TEST(ReaderMessages, Counts_GoOnOverAllWriters) {
  struct Counts final : Transport {
    std::vector<std::int32_t> seen;
    void send(BytesView message, std::span<const Locator>) override {
      auto walker = *MessageReader::open(message);
      for (auto next = walker.next(); next && *next; next = walker.next()) {
        if ((*next)->id == SubmessageId::acknack) seen.push_back(read_acknack(**next)->count);
        if ((*next)->id == SubmessageId::nack_frag) seen.push_back(read_nack_frag(**next)->count);
      }
    }
  } counts;
  MessageSender sender(counts, kHere);
  ReaderMessages messages(testing::kReader, sender);
  const Locator somewhere = *Locator::parse("127.0.0.1", 1);
  for (std::uint8_t i = 1; i <= 2; ++i) {
    const Destination to{GuidPrefix::from(Bytes(12, i)), {&somewhere, 1}};
    messages.acknack(to, testing::kWriter, SequenceNumberSet({1}), true);
    messages.nack_frag(to, testing::kWriter, {1}, FragmentNumberSet({1}));
    sender.flush();
  }
  EXPECT_THAT(counts.seen, ElementsAre(1, 2, 3, 4));
}

}  // namespace
}  // namespace ddssec::rtps
