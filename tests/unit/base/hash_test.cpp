// Hashes against published vectors, wiping and comparison.
#include "base/hash.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

// FIPS 180-4, examples of NIST.
TEST(Sha256, PublishedVectors_AreReproduced) {
  EXPECT_EQ(to_hex(sha256(BytesView())),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(to_hex(sha256(as_bytes("abc"))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(Sha256, Parts_AreHashedAsOneText) {
  EXPECT_EQ(sha256({as_bytes("a"), {}, as_bytes("bc")}), sha256(as_bytes("abc")));
  Sha256Digest out;
  sha256({as_bytes("ab"), as_bytes("c")}, out);
  EXPECT_EQ(out, sha256(as_bytes("abc")));
}

// RFC 4231, test cases 1, 2 and 6: a key shorter than a block, a short one, and a longer one.
TEST(HmacSha256, PublishedVectors_AreReproduced) {
  EXPECT_EQ(to_hex(hmac_sha256(Bytes(20, 0x0b), {as_bytes("Hi There")})),
            "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
  EXPECT_EQ(to_hex(hmac_sha256(as_bytes("Jefe"),
                               {as_bytes("what do ya want "), as_bytes("for nothing?")})),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(to_hex(hmac_sha256(Bytes(131, 0xaa), {as_bytes("Test Using Larger Than Block-Size Key "
                                                           "- Hash Key First")})),
            "60e431591ee0b67f0d8a26aacbf5b77f8e0bc6213728c5140546040f0ee37f54");
}

// RFC 1321, A.5.
TEST(Md5, PublishedVectors_AreReproduced) {
  EXPECT_EQ(to_hex(md5({})), "d41d8cd98f00b204e9800998ecf8427e");
  EXPECT_EQ(to_hex(md5(as_bytes("message digest"))), "f96b697d7cb7938d525a2f31aaf161d0");
}

TEST(Wipe, EveryOctet_IsZero) {
  Bytes octets = {1, 2, 3};
  wipe(MutableBytes(octets).first(2));
  EXPECT_EQ(octets, (Bytes{0, 0, 3}));
}

TEST(ConstantTimeEqual, LengthAndEveryOctet_AreCompared) {
  const Bytes octets = {1, 2, 3};
  EXPECT_TRUE(constant_time_equal(octets, Bytes{1, 2, 3}));
  EXPECT_TRUE(constant_time_equal({}, {}));
  EXPECT_FALSE(constant_time_equal(octets, Bytes{1, 2}));
  EXPECT_FALSE(constant_time_equal(octets, Bytes{1, 2, 3, 0}));
  for (std::size_t i = 0; i < octets.size(); ++i) {
    auto other = octets;
    other[i] ^= 0x80;
    EXPECT_FALSE(constant_time_equal(octets, other)) << i;
  }
}

}  // namespace
}  // namespace ddssec
