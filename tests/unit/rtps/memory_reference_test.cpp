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

TEST(MemoryReference, InEitherByteOrder_ComesAsItWasSent) {
  for (const auto endian : {Endian::little, Endian::big}) {
    const auto octets = written(referring(), endian);
    const auto read = read_data(view_of(octets)).value();
    EXPECT_EQ(read.inline_qos.memory, kReference);
    EXPECT_TRUE(read.payload.empty());
    EXPECT_EQ(read.kind, PayloadKind::none);
    EXPECT_LT(octets.size(), 80u);
  }
}

TEST(MemoryReference, WithoutIt_DataHasNoFurtherOctet) {
  Data data{kReader, kWriter, {7}};
  const auto octets = written(data);
  EXPECT_EQ(octets.size(), 24u);
  EXPECT_FALSE(read_data(view_of(octets))->inline_qos.memory);
}

TEST(MemoryReference, Cut_Refused) {
  const Bytes whole(28, 1);
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_EQ(code_of(read_memory_reference(BytesView(whole).first(size), Endian::little)),
              Code::rtps_parameter_invalid);
  EXPECT_TRUE(read_memory_reference(whole, Endian::little));
}

}  // namespace
}  // namespace ddssec::rtps
