// The submessage that ends an entity, octet for octet.
#include "plugins/cyclonedds/disposal.hpp"

#include <gtest/gtest.h>

#include "base/parameter_ids.hpp"

namespace ddssec::cyclonedds {
namespace {

// RTPS 2.5, clauses 9.4.5.4 (DATA), 9.6.4.8 (KEY_HASH) and 9.6.4.9 (STATUS_INFO).
TEST(Disposal, EndedEndpoint_IsADataWithTheKeyAndItsStatus) {
  Guid gone{{}, EntityId{{0, 0, 1, 0xc1}}};
  gone.prefix.octets.fill(0xab);
  std::array<std::uint8_t, 200> octets{};
  rtps::SpanWriter out(octets);
  write(out, {.reader = EntityId{{0, 0, 0, 0}},
              .writer = EntityId{{0, 1, 0, 0xc2}},
              .number = rtps::SequenceNumber{7},
              .key = pid::kParticipantGuid,
              .gone = gone});
  const std::string guid = to_hex(gone.octets());
  EXPECT_EQ(to_hex(BytesView(octets).first(out.size())),
            "150b5000"  // DATA of 80 octets, little endian, with inline QoS and a key
            "00001000"  // no extra flags, 16 octets to the inline QoS
            "00000000"
            "000100c2"  // reader, writer
            "00000000"
            "07000000"  // sequence number
            "70001000" +
                guid +  // PID_KEY_HASH
                "71000400"
                "00000003"  // PID_STATUS_INFO: disposed and unregistered
                "01000000"  // PID_SENTINEL
                "00030000"  // PL_CDR_LE
                "50001000" +
                guid +  // PID_PARTICIPANT_GUID
                "01000000");
}

}  // namespace
}  // namespace ddssec::cyclonedds
