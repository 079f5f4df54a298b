// Announcements that hide how an endpoint is protected.
#include "tests/unit/cryptography/announcements.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr std::uint16_t kSecurityInfo = 0x1004;
constexpr std::uint32_t kValid = 0x80000000;

// Returns the list with the attributes, in an EndpointSecurityInfo, before its sentinel.
Bytes with_info(Bytes list, std::uint32_t attributes, std::uint16_t id = kSecurityInfo,
                std::uint16_t size = 8) {
  const Bytes sentinel(list.end() - 4, list.end());
  list.resize(list.size() - 4);
  append(list, id, 2, true);
  append(list, size, 2, true);
  if (size >= 4) append(list, attributes, 4, true);
  if (size > 4) list.resize(list.size() + size - 4);
  append(list, sentinel);
  return list;
}

struct HiddenEndpointsTest : AnnouncedEndpointsTest {
  Code hear(const Bytes& payload, const EntityId& writer = kPublications) {
    const DataMessage message{.writer = writer, .number = next_number++, .payload = payload};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  bool hides(const Bytes& payload) {
    OneOwner fresh;
    const DataMessage message{.writer = kPublications, .payload = payload};
    EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, fresh)), Code{});
    EXPECT_FALSE(fresh.peer.announced.hides_readers());
    return fresh.peer.announced.hides_writers();
  }
  const AnnouncedEndpoints& announced() const { return peers.peer.announced; }
};

TEST_F(HiddenEndpointsTest, OneValidSecurityInfo_HidesNothing) {
  const auto plain = announcement(1, 16);
  EXPECT_FALSE(hides(with_info(plain, kValid)));
  EXPECT_FALSE(hides(with_info(plain, kValid | 3, kSecurityInfo, 12)));
  EXPECT_TRUE(hides(plain));
  EXPECT_TRUE(hides(with_info(plain, 0)));
  EXPECT_TRUE(hides(with_info(plain, 0x7fffffff)));
  EXPECT_TRUE(hides(with_info(plain, kValid, kSecurityInfo, 0)));
  for (const auto id : {0x5004, 0x9004, 0xd004}) {
    const auto flagged = static_cast<std::uint16_t>(id);
    EXPECT_TRUE(hides(with_info(plain, kValid, flagged))) << id;
    EXPECT_TRUE(hides(with_info(with_info(plain, kValid), 0, flagged))) << id;
  }
  EXPECT_TRUE(hides(with_info(with_info(plain, kValid), kValid)));
  auto twice = plain;
  for (int i = 0; i < 256; ++i) twice = with_info(twice, kValid);
  EXPECT_TRUE(hides(with_info(twice, kValid)));
}

TEST_F(HiddenEndpointsTest, Writers_AreToldApartFromReaders) {
  EXPECT_EQ(hear(announcement(1, 16), kSubscriptions), Code{});
  EXPECT_TRUE(announced().hides_readers());
  EXPECT_FALSE(announced().hides_writers());
  EXPECT_EQ(hear(announcement(1, 16), {{0, 0, 3, 0xc2}}), Code{});
  EXPECT_TRUE(announced().hides_writers()) << "in the clear, inside of a protected message";
}

TEST_F(HiddenEndpointsTest, EndOfAnEndpoint_HidesNothing) {
  EXPECT_EQ(hear(with_info(announcement(1, 16), kValid)), Code{});
  EXPECT_EQ(dispose(1, kDisposed | kUnregistered), Code{});
  acknowledge();
  EXPECT_FALSE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, RepeatedAfterAcknowledgement_Counts) {
  EXPECT_EQ(hear(with_info(announcement(1, 16), kValid)), Code{});
  acknowledge();
  next_number = 1;
  EXPECT_EQ(hear(announcement(2, 16)), Code{});
  EXPECT_TRUE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, WriterHiddenInFragments_IsFound) {
  EXPECT_EQ(fragments(1, with_info(announcement(1, 6'000), kValid)), Code{});
  EXPECT_FALSE(announced().hides_writers());
  EXPECT_EQ(fragments(2, announcement(2, 6'000)), Code{});
  EXPECT_TRUE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, SecuredEndpoints_AreKnownUntilTheirEnd) {
  const auto is_known = [&] { return announced().has_secured(endpoint(1), true); };
  EXPECT_FALSE(is_known());
  EXPECT_EQ(hear(announcement(1, 16), {{0, 0, 3, 0xc2}}), Code{});
  EXPECT_FALSE(is_known()) << "announced in the clear";
  EXPECT_EQ(hear(announcement(1, 16)), Code{});
  EXPECT_TRUE(is_known());
  EXPECT_FALSE(announced().has_secured(endpoint(1), false));
  EXPECT_FALSE(announced().has_secured(endpoint(2), true));
  acknowledge();
  EXPECT_TRUE(is_known());
  EXPECT_EQ(dispose(1, kDisposed), Code{});
  acknowledge();
  EXPECT_FALSE(is_known());
}

}  // namespace
}  // namespace ddssec::cryptography
