// A writer, some of whose readers find payloads in shared memory.
#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;

const Locator kThere = *Locator::parse("127.0.0.1", 2);
const GuidPrefix kC = GuidPrefix::from(Bytes(12, 0xcc));
constexpr MemoryReference kReference{7, 64, 2, 5000};

// Notes the requests that it gets.
struct Memory final : SampleMemory {
  std::optional<MemoryReference> store(const Change& change, SequenceNumber needed_from,
                                       MonotonicTime) override {
    stored.push_back(change.sequence_number.value);
    needed.push_back(needed_from.value);
    return is_full ? std::nullopt : std::optional(kReference);
  }
  std::vector<std::int64_t> stored, needed;
  bool is_full = false;
};

struct Odd final : ChangeFilter {
  std::optional<bool> passes(const Change& change) override {
    return change.payload.view()[0] % 2 == 1;
  }
};

// Sorts what is sent by the port that it is sent to.
struct Sorted final : Transport {
  std::map<std::uint32_t, std::vector<Data>> data;
  std::map<std::uint32_t, int> fragments, heartbeats, gaps;
  std::deque<Bytes> kept;
  void send(BytesView message, std::span<const Locator> to) override {
    kept.push_back(to_bytes(message));
    for (const auto& locator : to) {
      auto walker = *MessageReader::open(kept.back());
      for (auto next = walker.next(); next && *next; next = walker.next()) {
        const auto id = (**next).id;
        if (id == SubmessageId::data) data[locator.port].push_back(*read_data(**next));
        fragments[locator.port] += id == SubmessageId::data_frag ? 1 : 0;
        heartbeats[locator.port] += id == SubmessageId::heartbeat ? 1 : 0;
        gaps[locator.port] += id == SubmessageId::gap ? 1 : 0;
      }
    }
  }
};

struct Writing {
  explicit Writing(std::shared_ptr<ChangeFilter> of_b = {},
                   std::shared_ptr<ChangeFilter> of_c = {}) {
    writer.match({b, true, false, {kHere}, false, std::move(of_b)}, now);
    writer.match({c, true, false, {kThere}, false, std::move(of_c)}, now);
    writer.memory().use(&memory);
    writer.memory().set_reading(kB, true);
    clear();
  }
  void clear() {
    sent.data.clear(), sent.gaps.clear(), sent.heartbeats.clear(), sent.fragments.clear();
  }
  SequenceNumber write(std::uint8_t octet = 1, std::size_t size = 5000) {
    Change change;
    change.payload = Payload::copy_of(Bytes(size, octet));
    return writer.write(std::move(change), now);
  }
  bool came_as_reference(std::uint32_t port, std::size_t count = 1) {
    const auto& all = sent.data[port];
    return all.size() == count && std::ranges::all_of(all, [](const Data& data) {
             return data.inline_qos.memory == kReference && data.payload.empty();
           });
  }
  bool came_whole(std::uint32_t port, std::size_t count = 1) {
    const auto& all = sent.data[port];
    return all.size() == count && std::ranges::all_of(all, [](const Data& data) {
             return !data.inline_qos.memory && data.payload.size() == 5000;
           });
  }
  void acknowledge(const Guid& reader, std::int64_t base, std::vector<std::int64_t> missing = {}) {
    SequenceNumberSet set({base});
    for (const auto number : missing) set.insert({number});
    writer.on_acknack(reader.prefix, {reader.entity, testing::kWriter, set, ++count}, now, true,
                      KeyAge::newest);
  }

  Sorted sent;
  MessageSender sender{sent, kA};
  StatefulWriter writer{{kA, testing::kWriter}, keep_all(), sender};
  Memory memory;
  const Guid b{kB, testing::kReader}, c{kC, testing::kReader};
  MonotonicTime now = std::chrono::seconds(1);
  std::int32_t count = 0;
};

TEST(MemoryWriting, OneOfTwoReads_EachGetsItsForm) {
  Writing it;
  it.write();
  EXPECT_TRUE(it.came_as_reference(kHere.port));
  EXPECT_TRUE(it.came_whole(kThere.port));
  EXPECT_GT(it.sent.heartbeats[kHere.port], 0);
  EXPECT_GT(it.sent.heartbeats[kThere.port], 0);
}

TEST(MemoryWriting, BothRead_NoPayloadIsSent) {
  Writing it;
  it.writer.memory().set_reading(kC, true);
  it.write();
  EXPECT_TRUE(it.came_as_reference(kHere.port));
  EXPECT_TRUE(it.came_as_reference(kThere.port));
  it.writer.memory().set_reading(kC, false);
  it.clear();
  it.write();
  EXPECT_TRUE(it.came_as_reference(kHere.port));
  EXPECT_TRUE(it.came_whole(kThere.port));
}

TEST(MemoryWriting, MemoryIsFull_AllGetPayloads) {
  Writing it;
  it.memory.is_full = true;
  it.write();
  EXPECT_TRUE(it.came_whole(kHere.port));
  EXPECT_TRUE(it.came_whole(kThere.port));
}

TEST(MemoryWriting, NoLongerUsed_AllGetPayloads) {
  Writing it;
  it.writer.memory().use(nullptr);
  it.write();
  EXPECT_TRUE(it.came_whole(kHere.port));
  EXPECT_TRUE(it.came_whole(kThere.port));
  EXPECT_TRUE(it.memory.stored.empty());
}

TEST(MemoryWriting, Requested_SentAsPayload) {
  Writing it;
  it.write();
  it.clear();
  it.acknowledge(it.b, 1, {1});
  EXPECT_TRUE(it.came_whole(kHere.port));
}

TEST(MemoryWriting, SamplesAreNeeded_UntilTheSlowestHasThem) {
  Writing it;
  for (int i = 0; i < 4; ++i) it.write();
  it.acknowledge(it.b, 4);
  it.write();
  it.acknowledge(it.c, 3);
  it.write();
  it.acknowledge(it.c, 7);
  it.acknowledge(it.b, 7);
  it.write();
  EXPECT_EQ(it.memory.stored, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(it.memory.needed, (std::vector<std::int64_t>{1, 1, 1, 1, 1, 3, 7}));
}

TEST(MemoryWriting, ReaderThatStops_HoldsNoPlaceAfterTheBound) {
  Writing it;
  it.write();
  it.acknowledge(it.b, 2);
  it.now += Timeliness::kMaxDelay - std::chrono::milliseconds(1);
  it.write();
  it.acknowledge(it.b, 3);
  it.now += MatchedReaders::kCheckPeriod;
  it.write();
  EXPECT_EQ(it.memory.needed, (std::vector<std::int64_t>{1, 1, 3}));
}

TEST(MemoryWriting, AllReadersStop_NoPlaceIsHeldAfterTheBound) {
  Writing it;
  it.write();
  it.now += Timeliness::kMaxDelay;
  it.write();
  EXPECT_EQ(it.memory.needed, (std::vector<std::int64_t>{1, 2}));
}

TEST(MemoryWriting, StoppedReaderCatchesUp_HoldsPlacesAgain) {
  Writing it;
  it.write();
  it.acknowledge(it.b, 2);
  it.now += Timeliness::kMaxDelay;
  it.write();
  it.acknowledge(it.b, 3);
  it.acknowledge(it.c, 2);
  it.now += MatchedReaders::kCheckPeriod;
  it.write();
  EXPECT_EQ(it.memory.needed, (std::vector<std::int64_t>{1, 2, 2}));
}

TEST(MemoryWriting, Filtered_EachGetsWhatPassesInItsForm) {
  Writing it(std::make_shared<Odd>(), std::make_shared<Odd>());
  it.write(1);
  it.write(2);
  it.write(3);
  EXPECT_TRUE(it.came_as_reference(kHere.port, 2));
  EXPECT_TRUE(it.came_whole(kThere.port, 2));
  EXPECT_EQ(it.sent.gaps[kHere.port], 1);
}

TEST(MemoryWriting, OnlyTheMemoryReaderFilters_OtherGetsAll) {
  Writing it(std::make_shared<Odd>());
  it.write(2);
  EXPECT_TRUE(it.sent.data[kHere.port].empty());
  EXPECT_TRUE(it.came_whole(kThere.port));
}

TEST(MemoryWriting, Readdressed_ReferenceGoesToTheNewAddress) {
  Writing it;
  const auto other = *Locator::parse("127.0.0.1", 3);
  it.writer.readdress(it.b, {other}, it.now);
  it.clear();
  it.write();
  EXPECT_TRUE(it.came_as_reference(3));
  EXPECT_TRUE(it.sent.data[kHere.port].empty());
}

TEST(MemoryWriting, Unmatched_OthersGoOn) {
  Writing it;
  it.writer.unmatch(it.b);
  it.clear();
  it.write();
  EXPECT_TRUE(it.sent.data[kHere.port].empty());
  EXPECT_TRUE(it.came_whole(kThere.port));
}

// The reader at this address drops what it does not need.
TEST(MemoryWriting, SharedAddress_BothForms) {
  Writing it;
  it.writer.readdress(it.c, {kHere}, it.now);
  it.clear();
  it.write();
  ASSERT_EQ(it.sent.data[kHere.port].size(), 2u);
  EXPECT_TRUE(it.sent.data[kHere.port][0].inline_qos.memory);
  EXPECT_FALSE(it.sent.data[kHere.port][1].inline_qos.memory);
}

TEST(MemoryWriting, ElsewherePayload_IsDelivered) {
  Pair pair(keep_all());
  pair.match();
  Data data{testing::kReader, testing::kWriter, {1}};
  EXPECT_TRUE(pair.reader.on_data(kA, data, {}, Payload::copy_of(Bytes(300, 9)), KeyAge::newest));
  ASSERT_EQ(pair.delivered.size(), 1u);
  EXPECT_EQ(pair.delivered[0].payload.size(), 300u);
}

}  // namespace
}  // namespace ddssec::rtps
