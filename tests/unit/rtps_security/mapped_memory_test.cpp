// What a peer may say about shared memory, and where a reference may lead.
#include "rtps/security/mapped_memory.hpp"

#include <poll.h>

#include <gtest/gtest.h>

#include "rtps/memory/sample_slots.hpp"
#include "tests/unit/rtps_security/mapped.hpp"

namespace ddssec::rtps::mapped {
namespace {

using memory::MemoryRefusal;
using namespace std::chrono_literals;

TEST(MappedMemory, Offered_PayloadsAreFetched) {
  Sides sides;
  sides.share();
  const auto reference = sides.put();
  const auto payload = sides.mapped.fetch(sides.writer, reference, sides.now);
  ASSERT_EQ(payload.size(), 5000u);
  EXPECT_TRUE(std::ranges::all_of(payload.view(), [](auto octet) { return octet == 7; }));
  EXPECT_EQ(sides.mapped.segments(), 1u);
  sides.mapped.remove_reader(sides.writer, kReader);
  EXPECT_EQ(sides.mapped.segments(), 0u);
  EXPECT_EQ(sides.fetched(reference), 0u);
}

TEST(MappedMemory, HostileReference_LeadsNowhere) {
  Sides sides;
  sides.share();
  const auto good = sides.put();
  ASSERT_EQ(sides.fetched(good), 5000u);
  const auto with = [&](auto&& change) {
    auto reference = good;
    change(reference);
    return sides.fetched(reference);
  };
  const auto size = sides.slots.segment().octets();
  EXPECT_EQ(with([](auto& r) { r.length = 0; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.length = ~0u; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.length = MappedMemory::kMaxPayload + 1; }), 0u);
  EXPECT_EQ(with([&](auto& r) { r.length = static_cast<std::uint32_t>(size); }), 0u);
  EXPECT_EQ(with([&](auto& r) { r.offset = size; }), 0u);
  EXPECT_EQ(with([&](auto& r) { r.offset = size - 64; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.offset = ~std::uint64_t{63}; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.offset = 1; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.offset = 64; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.generation = 0; }), 0u);
  EXPECT_EQ(with([](auto& r) { ++r.generation; }), 0u);
  EXPECT_EQ(with([](auto& r) { r.generation += 2; }), 0u);
  EXPECT_TRUE(sides.answers.empty());
  EXPECT_EQ(with([](auto& r) { ++r.segment; }), 0u);
  EXPECT_EQ(sides.mapped.fetch({GuidPrefix{}, kWriter}, good, sides.now).size(), 0u);
  EXPECT_EQ(sides.fetched(good), 5000u);
}

// A reference costs its sender only a few octets.
TEST(MappedMemory, SamePayloadNamedAgainAndAgain_CopiedWithinALimit) {
  Sides sides;
  constexpr std::size_t kSize = std::size_t{8} << 20;
  auto large = memory::SampleSlots::make(79, kSize).value();
  std::swap(sides.slots, large);
  sides.share();
  const auto reference = sides.put(kSize);
  std::int64_t copied = 0;
  for (int i = 0; i < 200; ++i) copied += static_cast<std::int64_t>(sides.fetched(reference));
  EXPECT_LE(copied, MappedMemory::kCopiedAtOnce);
  EXPECT_GT(copied, MappedMemory::kCopiedAtOnce / 2);
  EXPECT_EQ(sides.fetched(reference), 0u);
  sides.now += 100ms;
  EXPECT_EQ(sides.fetched(reference), kSize);
}

struct Waiting : Sides {
  int said = 0;
  MappedMemory waiting{*passing,
                       [](const GuidPrefix&, const MemoryAnswer&) {},
                       {},
                       [this](const GuidPrefix&) { ++said; }};
  void receive(std::size_t octets, int seconds = 5) {
    for (int i = 0; i < seconds; ++i, now += 1s) waiting.note_message(writer, octets, now);
  }
};

TEST(MappedMemory, LargeSamplesInMessagesAndNoOffer_ReportedOnce) {
  Waiting sides;
  sides.waiting.add_reader(sides.writer, kReader);
  sides.receive(MappedMemory::kMinLarge, 2);
  EXPECT_EQ(sides.said, 0);
  sides.receive(MappedMemory::kMinLarge);
  sides.waiting.add_reader(sides.writer, kSecondReader);
  sides.receive(MappedMemory::kMinLarge);
  EXPECT_EQ(sides.said, 1);
}

TEST(MappedMemory, SmallSamples_NoOfferIsExpected) {
  Waiting sides;
  sides.waiting.add_reader(sides.writer, kReader);
  sides.receive(MappedMemory::kMinLarge - 1);
  EXPECT_EQ(sides.said, 0);
}

TEST(MappedMemory, WriterOfAnotherMachineOrUnmatched_NoOfferIsExpected) {
  Waiting sides;
  sides.receive(MappedMemory::kMinLarge);
  sides.waiting.add_reader(sides.writer, kReader, false);
  sides.receive(MappedMemory::kMinLarge);
  EXPECT_EQ(sides.said, 0);
}

TEST(MappedMemory, Offered_LargeSamplesMayStillComeInMessages) {
  Waiting sides;
  sides.waiting.add_reader(sides.writer, kReader);
  sides.waiting.on_offer(sides.prefix, sides.offer(), sides.now);
  sides.receive(MappedMemory::kMinLarge);
  EXPECT_EQ(sides.said, 0);
}

TEST(MappedMemory, ParticipantsOfOneIdentity_ShareTheLimitForCopies) {
  Sides sides;
  constexpr std::size_t kSize = std::size_t{8} << 20;
  auto large = memory::SampleSlots::make(79, kSize).value();
  std::swap(sides.slots, large);
  MappedMemory mapped(
      *sides.passing, [](const GuidPrefix&, const MemoryAnswer&) {},
      [](const GuidPrefix& prefix) {
        return std::string(prefix.octets[0] < 10 ? "CN=carol" : "CN=bob");
      });
  const auto writer_of = [](std::uint8_t number) {
    return Guid{GuidPrefix::from(Bytes(12, number)), kWriter};
  };
  for (const std::uint8_t number : {8, 9, 10}) {
    mapped.add_reader(writer_of(number), kReader);
    mapped.on_offer(writer_of(number).prefix, sides.offer(), sides.now);
    for (int i = 0; i < 5; ++i) {
      sides.passing->serve(sides.now);
      mapped.serve(sides.now);
    }
  }
  const auto reference = sides.put(kSize);
  const auto copied = [&](std::uint8_t number) {
    std::int64_t out = 0;
    for (int i = 0; i < 100; ++i)
      out +=
          static_cast<std::int64_t>(mapped.fetch(writer_of(number), reference, sides.now).size());
    return out;
  };
  EXPECT_GT(copied(8), MappedMemory::kCopiedAtOnce / 2);
  EXPECT_EQ(copied(9), 0);
  EXPECT_GT(copied(10), MappedMemory::kCopiedAtOnce / 2);
}

TEST(MappedMemory, LargeSegmentsOfOneParticipant_AreLimited) {
  Sides sides;
  std::vector<memory::SampleSlots> all;
  std::size_t refused = 0, mapped = 0;
  for (std::uint8_t i = 0; i < 20; ++i) {
    // A hostile writer may offer one memory under many names.
    if (i == 0) all.push_back(memory::SampleSlots::make(1000, std::size_t{16} << 20).value());
    MemoryOffer offer{{{9, 9, i, 2}},
                      sides.passing->offer(all[0].segment(), sides.random, sides.now).value()};
    sides.mapped.add_reader({sides.prefix, offer.writer}, kReader);
    sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
    sides.exchange();
    ASSERT_EQ(sides.answers.size(), 1u);
    (sides.answers[0].refusal ? refused : mapped) += 1;
    sides.answers.clear();
  }
  EXPECT_LE(mapped * all[0].segment().octets(), MappedMemory::kMaxOctetsOfOne);
  EXPECT_GT(refused, 0u);
}

TEST(MappedMemory, UnknownSegment_WriterIsToldWithinABudget) {
  Sides sides;
  auto reference = sides.put();
  for (int i = 0; i < 100; ++i) {
    ++reference.segment;
    EXPECT_EQ(sides.fetched(reference), 0u);
  }
  ASSERT_EQ(sides.answers.size(), 1u);
  EXPECT_EQ(sides.answers[0].refusal, MemoryRefusal::other_segment);
}

TEST(MappedMemory, WriterNotMatched_Refused) {
  Sides sides;
  auto offer = sides.offer();
  offer.writer = kReader;
  sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
  ASSERT_EQ(sides.answers.size(), 1u);
  EXPECT_EQ(sides.answers[0].refusal, MemoryRefusal::not_matched);
}

// Returns the answer to an offer that was changed by `change`.
template <class F>
std::optional<MemoryRefusal> answer_to(F&& change) {
  Sides sides;
  auto offer = sides.offer();
  change(offer.offer, sides);
  sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
  sides.exchange();
  sides.now += MappedMemory::kMaxRequest;
  sides.exchange();
  EXPECT_EQ(sides.answers.size(), 1u);
  EXPECT_EQ(sides.mapped.segments(), 0u);
  return sides.answers.empty() ? std::nullopt : sides.answers[0].refusal;
}

TEST(MappedMemory, HostileOffer_RefusedWithItsReason) {
  EXPECT_EQ(answer_to([](auto& offer, auto&) { offer.name[0] ^= 1; }), MemoryRefusal::no_socket);
  EXPECT_EQ(answer_to([](auto& offer, auto&) { ++offer.process; }), MemoryRefusal::wrong_process);
  EXPECT_EQ(answer_to([](auto& offer, auto&) { offer.process = 0; }), MemoryRefusal::wrong_process);
  EXPECT_EQ(answer_to([](auto& offer, auto&) { ++offer.memory.inode; }),
            MemoryRefusal::other_memory);
  EXPECT_EQ(answer_to([](auto& offer, auto&) { ++offer.memory.device; }),
            MemoryRefusal::other_memory);
  const auto wrong_token = [](auto& offer, auto&) {
    offer.token = memory::Token::copy_of(Bytes(32, 1)).value();
  };
  EXPECT_EQ(answer_to(wrong_token), MemoryRefusal::no_answer);
  const auto late = [](auto&, auto& sides) {
    sides.now += memory::OpenOffers::kLifetime;
    sides.passing->serve(sides.now);
  };
  EXPECT_EQ(answer_to(late), MemoryRefusal::no_answer);
}

TEST(MappedMemory, SilentProcess_RequestEndsInTime) {
  Sides sides;
  sides.mapped.on_offer(sides.prefix, sides.offer(), sides.now);
  sides.mapped.serve(sides.now);
  EXPECT_EQ(sides.mapped.next_tick(), sides.now + MappedMemory::kMaxRequest);
  sides.now += MappedMemory::kMaxRequest;
  sides.mapped.serve(sides.now);
  ASSERT_EQ(sides.answers.size(), 1u);
  EXPECT_EQ(sides.answers[0].refusal, MemoryRefusal::no_answer);
  EXPECT_EQ(sides.mapped.next_tick(), kNever);
}

TEST(MappedMemory, ManyOffers_FewAreTaken) {
  Sides sides;
  for (int i = 0; i < 60; ++i) sides.mapped.on_offer(sides.prefix, sides.offer(), sides.now);
  sides.exchange();
  EXPECT_EQ(sides.answers.size(), 1u);
  EXPECT_EQ(sides.mapped.segments(), 1u);
  EXPECT_GT(sides.passing->offers().size(), 50u);
}

TEST(MappedMemory, ManySilentRequestsOfOneParticipant_Limited) {
  Sides sides;
  std::size_t refused = 0;
  for (std::uint8_t i = 0; i < 20; ++i) {
    auto offer = sides.offer();
    offer.writer = {{9, 9, i, 2}};
    sides.mapped.add_reader({sides.prefix, offer.writer}, kReader);
    sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
    refused += sides.answers.size();
    sides.answers.clear();
  }
  EXPECT_EQ(refused, 20 - MappedMemory::kMaxRequestsOfOne);
}

// The thread that passes descriptors goes on with a request until its time is over.
TEST(MappedMemory, SilentRequestsReplacedAgainAndAgain_StillLimited) {
  Sides sides;
  const auto offer_all = [&] {
    for (std::uint8_t i = 0; i < MappedMemory::kMaxRequestsOfOne; ++i) {
      auto offer = sides.offer();
      offer.writer = {{9, 9, i, 2}};
      sides.mapped.add_reader({sides.prefix, offer.writer}, kReader);
      sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
    }
    return std::exchange(sides.answers, {}).size();
  };
  EXPECT_EQ(offer_all(), 0u);
  sides.now += 1s;
  EXPECT_EQ(offer_all(), MappedMemory::kMaxRequestsOfOne) << "refused";
  sides.exchange();
  sides.answers.clear();
  EXPECT_EQ(offer_all(), 0u) << "the former ones have ended";
}

TEST(MappedMemory, ManySegmentsOfOneParticipant_Limited) {
  Sides sides;
  std::vector<memory::SampleSlots> all;
  std::size_t refused = 0;
  for (std::uint8_t i = 0; i < 200; ++i) {
    all.push_back(memory::SampleSlots::make(1000u + i, 100).value());
    MemoryOffer offer{{{9, 9, i, 2}},
                      sides.passing->offer(all.back().segment(), sides.random, sides.now).value()};
    sides.mapped.add_reader({sides.prefix, offer.writer}, kReader);
    sides.mapped.on_offer(sides.prefix, std::move(offer), sides.now);
    sides.exchange();
    ASSERT_EQ(sides.answers.size(), 1u);
    refused += sides.answers[0].refusal == MemoryRefusal::no_memory ? 1 : 0;
    sides.answers.clear();
    sides.now += memory::OpenOffers::kLifetime;
  }
  EXPECT_EQ(refused, 200 - MappedMemory::kMaxOfOne);
  EXPECT_EQ(sides.mapped.segments(), MappedMemory::kMaxOfOne);
}

TEST(MappedMemory, SecondSegment_FormerOneIsStillRead) {
  Sides sides;
  sides.share();
  const auto first = sides.put();
  auto next = memory::SampleSlots::make(78, 10'000).value();
  std::swap(sides.slots, next);
  sides.share();
  const auto second = sides.put(600);
  EXPECT_EQ(sides.fetched(first), 5000u);
  EXPECT_EQ(sides.fetched(second), 600u);
  auto third = memory::SampleSlots::make(79, 10'000).value();
  std::swap(sides.slots, third);
  sides.share();
  EXPECT_EQ(sides.fetched(first), 0u);
  EXPECT_EQ(sides.fetched(second), 600u);
  EXPECT_EQ(sides.mapped.segments(), 2u);
  EXPECT_EQ(sides.mapped.next_tick(), sides.now + MappedMemory::kFormer);
  sides.now += MappedMemory::kFormer;
  sides.mapped.serve(sides.now);
  EXPECT_EQ(sides.fetched(second), 0u);
  EXPECT_EQ(sides.mapped.segments(), 1u);
  EXPECT_EQ(sides.mapped.next_tick(), kNever);
}

TEST(MappedMemory, DescriptorComes_ReadinessSaysSo) {
  Sides sides;
  sides.mapped.on_offer(sides.prefix, sides.offer(), sides.now);
  ASSERT_TRUE(sides.passing->start());
  pollfd waiting{.fd = sides.passing->descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waiting, 1, 5000), 1);
  sides.mapped.serve(sides.now);
  EXPECT_EQ(sides.mapped.segments(), 1u);
}

}  // namespace
}  // namespace ddssec::rtps::mapped
