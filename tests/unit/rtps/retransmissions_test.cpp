// What a writer sends besides new samples: GAPs of filtered changes, and what readers request
// again.
#include "rtps/reliability/retransmissions.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/filtered_writing.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "tests/support/slowdown.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const GuidPrefix kA = GuidPrefix::from(Bytes(12, 0xaa));
const Locator kHere = *Locator::parse("127.0.0.1", 1);
const Locator kThere = *Locator::parse("127.0.0.2", 1);

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

/// What was said, in words: "data 3 unicast", "gap 1-4", ...
struct Words final : Transport {
  std::vector<std::string> said;
  void send(BytesView message, std::span<const Locator> to) override {
    auto walker = *MessageReader::open(message);
    for (auto next = walker.next(); next && *next; next = walker.next()) {
      const auto words = words_of(**next);
      if (!words.empty()) said.push_back(words + (to.size() > 1 ? " to all" : ""));
    }
  }
  static std::string words_of(const SubmessageView& view) {
    const auto text = [](auto number) { return std::to_string(number.value); };
    switch (view.id) {
      case SubmessageId::data:
        return "data " + text(read_data(view)->sequence_number);
      case SubmessageId::data_frag:
        return "fragment " + text(read_data_frag(view)->first);
      case SubmessageId::gap:
        return "gap " + text(read_gap(view)->start) + "-" + text(read_gap(view)->list.base());
      case SubmessageId::heartbeat:
        return "heartbeat";
      default:
        return {};
    }
  }
};

/// Passes changes of more than one octet.
struct Filter final : ChangeFilter {
  std::optional<bool> passes(const Change& change) override { return change.payload.size() > 1; }
};

struct WriterParts : ::testing::Test {
  Words words;
  MessageSender sender{words, kA};
  WriterHistory history{keep_all()};
  WriterMessages messages{testing::kWriter, DurabilityKind::volatile_, sender, history};
  MatchedReaders readers{testing::kWriter, true};
  EvaluationAllowance evaluations;
  Retransmissions retransmissions{history, messages, evaluations};
  FilteredWriting filtered{readers, messages};
  MonotonicTime now = milliseconds(1000);

  static Qos keep_all() {
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    return qos;
  }
  const Change& add(std::size_t octets = 8) {
    Change change;
    change.payload = Payload::copy_of(Bytes(octets));
    return *history.find(history.add(std::move(change)));
  }
  std::vector<std::string> said() {
    sender.flush();
    return std::exchange(words.said, {});
  }
  bool request(ReaderProxy& proxy, std::initializer_list<std::int64_t> numbers) {
    SequenceNumberSet missing({*numbers.begin()});
    for (const auto number : numbers) missing.insert({number});
    return retransmissions.answer(proxy, readers.one(proxy), missing, now);
  }
  static NackFrag nack(std::int64_t sample, std::uint32_t fragments) {
    FragmentNumberSet missing({1});
    for (std::uint32_t i = 1; i <= fragments; ++i) missing.insert({i});
    return {testing::kReader, testing::kWriter, {sample}, missing, 1};
  }
};

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

// Before: one GAP for each number, so a late joiner of a writer that runs for days asked for hours.
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

/// Counts the changes that it gets.
struct CountingTransport final : Transport {
  std::size_t messages = 0;
  void send(BytesView, std::span<const Locator>) override { ++messages; }
};

// Before: one step for each number, 4.8 s for a hundred million.
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

/// Passes nothing, and counts how often it is asked.
struct CountingFilter final : ChangeFilter {
  std::optional<bool> passes(const Change&) override {
    ++asked;
    return false;
  }
  std::size_t asked = 0;
};

TEST_F(WriterParts, RequestsOfAFilteredReader_CostFewGapsAndEvaluations) {
  constexpr std::int64_t kHeld = 600;
  for (std::int64_t i = 0; i < kHeld; ++i) add();
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}}, {{1}});
  readers.set_filter(proxy, filter);
  std::size_t gaps = 0;
  for (std::int64_t base = 1; base <= 300; ++base) {
    SequenceNumberSet missing({base});
    for (std::int64_t number = base; number < base + 256; ++number) missing.insert({number});
    retransmissions.answer(proxy, readers.one(proxy), missing, now);
    gaps += said().size();
  }
  EXPECT_LE(gaps, 300u);
  EXPECT_EQ(filter->asked, EvaluationAllowance::kMaxOctets);
}

TEST_F(WriterParts, AnAnswerIsBounded) {
  constexpr auto kHalf = Retransmissions::kMaxOctetsPerAnswer / 2;
  for (int i = 0; i < 4; ++i) add(kHalf);
  sender.fragment_at(10'000);
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  EXPECT_TRUE(request(proxy, {1, 2, 3, 4}));
  EXPECT_EQ(said().size(), 2 * ((kHalf + 9'999) / 10'000));
}

TEST_F(WriterParts, FragmentsComeInPortions) {
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

TEST_F(WriterParts, AFilteredChange_GoesToThoseThatWantIt) {
  readers.add({guid(1), true, false, {kHere}, false, std::make_shared<Filter>()}, {{1}});
  filtered.send(add(1));
  EXPECT_THAT(said(), IsEmpty());
  filtered.send(add(2));
  EXPECT_THAT(said(), ElementsAre("gap 1-2", "data 2"));
  readers.add({guid(2), true, false, {kThere}}, {{3}});
  filtered.send(add(2));
  EXPECT_THAT(said(), ElementsAre("data 3 to all"));
  filtered.send(add(1));
  EXPECT_THAT(said(), ElementsAre("data 4"));
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

TEST_F(WriterParts, HeartbeatsAreCounted) {
  add();
  auto& proxy = readers.add({guid(1), true, false, {kHere}}, {{1}});
  for (int i = 0; i < 3; ++i) messages.heartbeat(readers.one(proxy), {1}, true);
  EXPECT_THAT(said(), ElementsAre("heartbeat", "heartbeat", "heartbeat"));
}

}  // namespace
}  // namespace ddssec::rtps
