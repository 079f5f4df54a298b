// What a writer sends besides new samples: GAPs of filtered changes, and changes that readers
// request again.
#include "rtps/reliability/retransmissions.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/filtered_writing.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps/writer_parts.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps::writer_parts {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const Locator kHere = *Locator::parse("127.0.0.1", 1);

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

TEST_F(WriterParts, ARequest_IsAnsweredWithWhatIsHeld) {
  for (int i = 0; i < 4; ++i) add();
  history.discard({3});
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{2}});
  EXPECT_TRUE(request(proxy, {1, 2, 3, 4, 5}));
  EXPECT_THAT(said(), ElementsAre("gap 1-2", "data 2", "gap 3-4", "data 4"))
      << "what was not written yet is not answered";
  EXPECT_FALSE(request(proxy, {1, 2})) << "it crossed the answer";
  EXPECT_THAT(said(), IsEmpty());
}

// With one GAP for each number, a late joiner would wait for hours for a writer that has run for
// days.
TEST(SparseHistory, NumbersThatWereUsedUp_AreOneGap) {
  Words words;
  MessageSender sender{words, kA};
  Qos qos;
  qos.history = {HistoryKind::keep_last, 1};
  WriterHistory history{qos};
  WriterMessages messages{testing::kWriter, DurabilityKind::transient_local, sender, history};
  MatchedReaders readers{testing::kWriter, true};
  EvaluationAllowance evaluations;
  Retransmissions retransmissions{history, messages, evaluations};
  for (int i = 0; i < 100'000; ++i) {
    Change change;
    change.key_hash = KeyHash{static_cast<std::uint8_t>(i == 0)};
    change.payload = Payload::copy_of(Bytes(8));
    history.add(std::move(change));
  }
  auto& proxy = readers.add({guid(1), true, true, {kHere}}, {{1}});
  SequenceNumberSet missing({1});
  for (std::int64_t number = 1; number <= 256; ++number) missing.insert({number});
  EXPECT_TRUE(retransmissions.answer(proxy, readers.one(proxy), missing, milliseconds(1000)));
  sender.flush();
  EXPECT_THAT(words.said, ElementsAre("data 1", "gap 2-100000"));
}

// Counts the changes that it gets.
struct CountingTransport final : Transport {
  std::size_t messages = 0;
  void send(BytesView, std::span<const Locator>) override { ++messages; }
};

// With one step for each number, a hundred million of them would take 4.8 s.
TEST(SparseHistory, LateJoiner_CostsWhatIsHeld) {
  CountingTransport transport;
  MessageSender sender{transport, kA};
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  qos.history = {HistoryKind::keep_last, 1};
  StatefulWriter writer({kA, testing::kWriter}, qos, sender);
  for (int i = 0; i < 1'000'000; ++i) {
    Change change;
    change.key_hash = KeyHash{static_cast<std::uint8_t>(i == 0)};
    writer.write(std::move(change), milliseconds(1));
  }
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint8_t n = 1; n <= 200; ++n)
    writer.match({guid(n), false, true, {kHere}}, milliseconds(1));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2) * test::kSlowdown)
      << "a step for each number takes 9 s";
  EXPECT_GT(transport.messages, 0u);
}

TEST_F(WriterParts, AnAnswer_IsBounded) {
  constexpr auto kHalf = Retransmissions::kMaxOctetsPerAnswer / 2;
  for (int i = 0; i < 4; ++i) add(kHalf);
  sender.fragment_at(10'000);
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  EXPECT_TRUE(request(proxy, {1, 2, 3, 4}));
  EXPECT_EQ(said().size(), 2 * ((kHalf + 9'999) / 10'000));
}

TEST_F(WriterParts, Fragments_ComeInPortions) {
  add(20'000);
  sender.fragment_at(1'000);
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  const auto portion = [&] {
    return retransmissions.send_portion(proxy, readers.one(proxy), now) ? said().size() : 0;
  };
  EXPECT_TRUE(retransmissions.begin(proxy, nack(1, 18), now));
  EXPECT_EQ(portion(), FragmentRepair::kFragmentsPerPortion);
  EXPECT_EQ(proxy.repair.due(), now + FragmentRepair::kPause);
  EXPECT_FALSE(retransmissions.begin(proxy, nack(1, 18), now)) << "it crossed the answer";
  EXPECT_EQ(portion(), FragmentRepair::kFragmentsPerPortion);
  EXPECT_EQ(portion(), 2u);
  EXPECT_EQ(proxy.repair.due(), kNever);
  EXPECT_TRUE(retransmissions.begin(proxy, nack(1, 18), now + FragmentRepair::kAnswerTime));
}

TEST_F(WriterParts, FragmentsOfWhatIsGone_AreAGap) {
  add();
  history.discard({1});
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  retransmissions.begin(proxy, nack(1, 3), now);
  EXPECT_FALSE(retransmissions.send_portion(proxy, readers.one(proxy), now));
  EXPECT_THAT(said(), ElementsAre("gap 1-2"));
  readers.acknowledge(proxy, {1});
  EXPECT_FALSE(retransmissions.send_portion(proxy, readers.one(proxy), now));
  EXPECT_THAT(said(), IsEmpty());
}

TEST_F(WriterParts, GapsThatAreDue_AreSentOnce) {
  readers.add({guid(1), true, false, {kHere}, false, std::make_shared<Filter>()}, {{1}});
  filtered.send_gaps({1});
  EXPECT_THAT(said(), IsEmpty());
  filtered.send(add(1));
  filtered.send(add(1));
  filtered.send_gaps({3});
  filtered.send_gaps({3});
  EXPECT_THAT(said(), ElementsAre("gap 1-3"));
}

}  // namespace
}  // namespace ddssec::rtps::writer_parts
