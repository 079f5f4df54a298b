// The reference that a DATA carries in place of its payload.
#include "wire/memory_reference.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/data.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr MemoryReference kReference{0x0102030405060708, 4096, 0x0a0b0c0d0e0f1011, 70'000};

Data referring() {
  Data out{kReader, kWriter, {7}};
  out.inline_qos.memory = kReference;
  return out;
}

TEST(MemoryReference, BothByteOrders_RoundTrip) {
  for (const auto endian : {Endian::little, Endian::big}) {
    const auto octets = written(referring(), endian);
    const auto read = read_data(view_of(octets)).value();
    EXPECT_EQ(read.inline_qos.memory, kReference);
    EXPECT_TRUE(read.payload.empty());
    EXPECT_EQ(read.kind, PayloadKind::none);
    EXPECT_LT(octets.size(), 80u);
  }
}

TEST(MemoryReference, DataWithoutIt_HasNoFurtherOctet) {
  Data data{kReader, kWriter, {7}};
  const auto octets = written(data);
  EXPECT_EQ(octets.size(), 24u);
  EXPECT_FALSE(read_data(view_of(octets))->inline_qos.memory);
}

// Returns the DATA with the parameter's value made longer or shorter by a whole number of words.
Bytes with_length_of(std::size_t size) {
  auto octets = written(referring(), Endian::little);
  const auto id = std::ranges::search(octets, Bytes{0x5f, 0x8d, 28, 0});
  EXPECT_EQ(id.size(), 4u);
  const auto at = id.begin() - octets.begin();
  octets[static_cast<std::size_t>(at) + 2] = static_cast<std::uint8_t>(size);
  if (size > 28)
    octets.insert(octets.begin() + at + 4, size - 28, std::uint8_t{1});
  else
    octets.erase(octets.begin() + at + 4, octets.begin() + at + 4 + (28 - static_cast<int>(size)));
  octets[2] = static_cast<std::uint8_t>(octets.size() - 4);
  return octets;
}

// Another vendor may use the number of the parameter for something else.
TEST(MemoryReference, AnotherLength_IsReadAsDataWithoutIt) {
  EXPECT_TRUE(read_data(view_of(with_length_of(28)))->inline_qos.memory);
  for (const std::size_t size : {0, 4, 24, 32, 64}) {
    const auto octets = with_length_of(size);
    const auto read = read_data(view_of(octets));
    ASSERT_TRUE(read) << size;
    EXPECT_FALSE(read->inline_qos.memory) << size;
  }
}

TEST(MemoryReference, TruncatedReference_IsRefused) {
  const Bytes whole(28, 1);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_EQ(code_of(read_memory_reference(BytesView(whole).first(size), Endian::little)),
              Code::rtps_parameter_invalid);
  EXPECT_TRUE(read_memory_reference(whole, Endian::little));
}

}  // namespace
}  // namespace ddssec::rtps
