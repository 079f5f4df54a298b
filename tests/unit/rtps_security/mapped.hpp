// Both sides of shared memory in one process.
#pragma once

#include <poll.h>

#include <gtest/gtest.h>

#include "rtps/memory/sample_slots.hpp"
#include "rtps/security/mapped_memory.hpp"

namespace ddssec::rtps::mapped {

using namespace std::chrono_literals;

inline constexpr EntityId kWriter{{1, 2, 3, 2}}, kReader{{1, 2, 3, 7}}, kSecondReader{{1, 2, 4, 7}};

/// A writer's side and a reader's side in one process.
struct Sides {
  Sides() { mapped.add_reader(writer, kReader); }
  MemoryOffer offer() {
    return {kWriter, passing->offer(slots.segment(), random, now, std::to_string(++peers)).value()};
  }
  /// Lets the descriptor arrive.
  void exchange() {
    for (int i = 0; i < 5; ++i) {
      passing->serve(now);
      mapped.serve(now);
    }
  }
  void share() {
    mapped.on_offer(prefix, offer(), now);
    exchange();
    ASSERT_EQ(answers, (std::vector<MemoryAnswer>{{kWriter, slots.segment().id(), {}}}));
    answers.clear();
  }
  MemoryReference put(std::size_t size = 5000) {
    const auto place = slots.begin({1}, now).value();
    std::ranges::fill(place.first(size), std::uint8_t{7});
    return slots.end({1}, size, now);
  }
  std::size_t fetched(const MemoryReference& reference) {
    return mapped.fetch(writer, reference, now).size();
  }

  SystemRandom random;
  MonotonicTime now = 100s;
  const GuidPrefix prefix = GuidPrefix::from(Bytes(12, 9));
  const Guid writer{prefix, kWriter};
  // There is no thread, so that the test sees each step.
  std::unique_ptr<memory::DescriptorPassing> passing =
      memory::DescriptorPassing::make(random).value();
  memory::SampleSlots slots = memory::SampleSlots::make(77, 10'000).value();
  std::vector<MemoryAnswer> answers;
  int peers = 0;  // another one for each offer, so that no limit of a peer is reached
  MappedMemory mapped{*passing, [this](const GuidPrefix& to, const MemoryAnswer& answer) {
                        EXPECT_EQ(to, prefix);
                        answers.push_back(answer);
                      }};
};

}  // namespace ddssec::rtps::mapped
