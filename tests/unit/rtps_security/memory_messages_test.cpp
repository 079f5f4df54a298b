// Offers of memory and their answers, in the form in which they are sent.
#include "rtps/security/memory_messages.hpp"

#include <poll.h>

#include <gtest/gtest.h>

#include "rtps/memory/sample_slots.hpp"
#include "tests/unit/rtps_security/mapped.hpp"

namespace ddssec::rtps::mapped {
namespace {

using memory::MemoryRefusal;
using namespace std::chrono_literals;

TEST(MemoryMessages, Offer_ComesAsItWasSent) {
  Sides sides;
  const auto offer = sides.offer();
  const auto read = offer_in(token_of(offer));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->writer, kWriter);
  EXPECT_EQ(read->offer.name, offer.offer.name);
  EXPECT_TRUE(read->offer.token == offer.offer.token);
  EXPECT_EQ(read->offer.process, offer.offer.process);
  EXPECT_EQ(read->offer.segment, offer.offer.segment);
  EXPECT_EQ(read->offer.memory, offer.offer.memory);
  EXPECT_FALSE(answer_in(token_of(offer)));
}

TEST(MemoryMessages, Answer_ComesAsItWasSent) {
  const MemoryAnswer mapped{kWriter, 77, {}};
  EXPECT_EQ(answer_in(token_of(mapped)), mapped);
  EXPECT_FALSE(offer_in(token_of(mapped)));
  for (std::uint32_t i = 0; i < memory::kRefusals; ++i) {
    const MemoryAnswer refused{kWriter, 77, static_cast<MemoryRefusal>(i)};
    EXPECT_EQ(answer_in(token_of(refused)), refused);
    EXPECT_NE(memory::to_string(*refused.refusal), "unknown");
  }
}

TEST(MemoryMessages, CutAnywhereOrLonger_Refused) {
  Sides sides;
  for (const auto& whole : {token_of(sides.offer()), token_of(MemoryAnswer{kWriter, 77, {}})}) {
    auto token = whole;
    auto& content = token.binary_properties[0].value;
    content.push_back(0);
    EXPECT_FALSE(offer_in(token) || answer_in(token));
    for (content.pop_back(); !content.empty();) {
      content.pop_back();
      EXPECT_FALSE(offer_in(token) || answer_in(token));
    }
    token = whole;
    token.class_id += "x";
    EXPECT_FALSE(offer_in(token) || answer_in(token));
    EXPECT_FALSE(offer_in({.class_id = whole.class_id}) || answer_in({.class_id = whole.class_id}));
  }
}

TEST(MemoryMessages, UnknownReason_IsARefusal) {
  auto token = token_of(MemoryAnswer{kWriter, 77, MemoryRefusal::full});
  token.binary_properties[0].value[12] = 0xff;
  const auto read = answer_in(token);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->refusal, MemoryRefusal::no_answer);
}

}  // namespace
}  // namespace ddssec::rtps::mapped
