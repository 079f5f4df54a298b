// Once endpoints are matched, a message allocates nothing. This is a program of its own because it
// replaces operator new.
#include <gtest/gtest.h>

#include "tests/support/counted_memory.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kSign = ProtectionKind::sign;
constexpr std::array kKinds = {kSign, kEncrypt, ProtectionKind::sign_with_origin_authentication,
                               ProtectionKind::encrypt_with_origin_authentication};

using counted_memory::allocations_of;

TEST(CryptographyAllocations, NewOfAnyKind_IsCounted) {
  EXPECT_EQ(allocations_of([] { ::operator delete(::operator new(1)); }), 1);
  constexpr std::align_val_t kAligned{64};
  EXPECT_EQ(allocations_of([] { ::operator delete(::operator new(1, kAligned), kAligned); }), 1);
}

TEST(CryptographyAllocations, MessagePath_AllocatesNothing) {
  for (const auto kind : kKinds) {
    TwoSides two(kind);
    const auto e = two.endpoints(endpoint_attributes(kind, is_encrypted(kind) ? kEncrypt : kSign));
    const auto data = data_submessage(64), ack = data_submessage(24, 0x06);
    const auto message = rtps_message({data});
    Bytes out(500), back(500);
    auto &a = two.a.transform(), &b = two.b.transform();
    const auto once = [&] {
      auto size = a.encode_serialized_payload(e.writer, data, out);
      bool good = size && b.decode_serialized_payload(e.reader, e.remote_writer,
                                                      BytesView(out).first(*size), back);
      size = a.encode_datawriter_submessage(e.writer, {&e.remote_reader, 1}, data, out);
      const auto group = BytesView(out).first(*size);
      good &= b.preprocess_secure_submessage({}, two.b.remote, group).has_value();
      good &= b.decode_datawriter_submessage(e.reader, e.remote_writer, group, back).has_value();
      size = b.encode_datareader_submessage(e.reader, {&e.remote_writer, 1}, ack, out);
      good &= a.decode_datareader_submessage(e.writer, e.remote_reader, BytesView(out).first(*size),
                                             back)
                  .has_value();
      size = a.encode_rtps_message(two.a.participant, {&two.a.remote, 1}, message, out);
      good &=
          b.decode_rtps_message(two.b.participant, two.b.remote, BytesView(out).first(*size), back)
              .has_value();
      if (!good) std::abort();
    };
    once();  // the sessions are expanded
    EXPECT_EQ(allocations_of([&] {
                for (int i = 0; i < 100; ++i) once();
              }),
              0);
  }
}

// A sender that changes its session often costs its receiver no allocation either, once the memory
// of its sessions is full. (Fast DDS changes it every 32 messages.)
TEST(CryptographyAllocations, NewSessionsOfASender_AllocateNothing) {
  TwoSides two(ProtectionKind::none, {}, {.max_blocks_per_session = 1});
  const auto e = two.endpoints(endpoint_attributes(ProtectionKind::none, kEncrypt));
  std::vector<Bytes> encoded;
  for (int i = 0; i < 200; ++i) encoded.push_back(encode_payload(two, e, Bytes(16)).value());
  Bytes back(100);
  const auto decode = [&](std::size_t i) {
    if (!two.b.transform().decode_serialized_payload(e.reader, e.remote_writer, encoded[i], back))
      std::abort();
  };
  for (std::size_t i = 0; i < 10; ++i) decode(i);
  EXPECT_EQ(allocations_of([&] {
              for (std::size_t i = 10; i < encoded.size(); ++i) decode(i);
            }),
            0);
}

// A forged message costs no allocation except that of the session that it names.
TEST(CryptographyAllocations, Forgeries_AllocateLittle) {
  TwoSides two(kEncrypt);
  const auto good = encode_message(two, rtps_message({data_submessage(40)})).value();
  Bytes out(good.size());
  ASSERT_TRUE(two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, good, out));
  auto bad = good;
  bad[60] ^= 1;
  EXPECT_EQ(allocations_of([&] {
              (void)two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, bad,
                                                          out);
            }),
            0);
  bad[33] ^= 1;
  EXPECT_LE(allocations_of([&] {
              (void)two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, bad,
                                                          out);
            }),
            2);
}

}  // namespace
}  // namespace ddssec::cryptography::testing
