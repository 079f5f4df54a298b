#include "wire/message_reader.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/test_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/acknack.hpp"
#include "wire/data.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_timestamp.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;
using testing::message;
using testing::written;

// Cyclone DDS issue 2402: datagrams of 0 to 40 octets.
TEST(Message, EveryTruncation_IsAShorterWalkOrARefusal) {
  const auto whole = message({written(InfoDestination{}), written(Heartbeat{{}, {}, {1}, {2}, 1})});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    auto opened = MessageReader::open(BytesView(whole).first(size));
    if (size < kHeaderSize) {
      EXPECT_EQ(code_of(opened), Code::rtps_not_a_message) << size;
      continue;
    }
    int seen = 0;
    auto next = opened->next();
    for (; next && *next; next = opened->next()) ++seen;
    EXPECT_LE(seen, 1);
    const bool at_a_border = size == 20 || size == 36;
    EXPECT_EQ(next.has_value(), at_a_border) << size;
  }
}

TEST(Message, LengthZero_MeansToTheEndExceptWhereAnEmptyBodyIsLegal) {
  auto octets = message({written(InfoTimestamp{}), written(InfoDestination{})});
  octets[26] = 0;  // the length of INFO_DST
  auto reader = *MessageReader::open(octets);
  EXPECT_EQ((*reader.next())->body.size(), 0u);
  EXPECT_EQ((*reader.next())->body.size(), 12u);
  EXPECT_FALSE(*reader.next());
}

TEST(Message, ASubmessage_CannotReachBeyondItsMessage) {
  for (std::uint8_t length : {13, 16, 255}) {
    auto octets = message({written(InfoDestination{})});
    octets[22] = length;
    auto reader = *MessageReader::open(octets);
    EXPECT_EQ(code_of(reader.next()), Code::rtps_submessage_overrun) << int{length};
  }
}

TEST(Message, OnlyTheLastSubmessage_MayHaveAnOddLength) {
  auto octets = message({written(InfoDestination{}), written(InfoDestination{})});
  octets[22] = 13;
  auto reader = *MessageReader::open(octets);
  EXPECT_EQ(code_of(reader.next()), Code::rtps_submessage_overrun);
  octets = message({written(InfoDestination{})});
  octets.push_back(0);
  octets[22] = 13;
  reader = *MessageReader::open(octets);
  EXPECT_EQ((*reader.next())->body.size(), 13u);
}

Bytes content(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Reads every submessage of the kinds that are in the capture.
Status read_all(BytesView octets) {
  auto reader = MessageReader::open(octets);
  if (!reader) return std::unexpected(reader.error());
  for (auto next = reader->next(); *next; next = reader->next()) {
    const auto& view = **next;
    Status status;
    auto check = [&](auto result) {
      if (!result) status = std::unexpected(result.error());
    };
    switch (view.id) {
      case SubmessageId::data:
        check(read_data(view));
        break;
      case SubmessageId::heartbeat:
        check(read_heartbeat(view));
        break;
      case SubmessageId::acknack:
        check(read_acknack(view));
        break;
      case SubmessageId::gap:
        check(read_gap(view));
        break;
      case SubmessageId::info_timestamp:
        check(read_info_timestamp(view));
        break;
      case SubmessageId::info_destination:
        check(read_info_destination(view));
        break;
      default:
        return fail(Code::malformed);
    }
    if (!status) return status;
  }
  return {};
}

TEST(Message, ACapturedRosSystem_IsUnderstoodCompletely) {
  int messages = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::data_path("foxglove-rtps/messages"))) {
    const auto status = read_all(content(entry.path()));
    EXPECT_TRUE(status) << entry.path() << " " << status.error().to_sentence();
    ++messages;
  }
  EXPECT_GT(messages, 10);
}

}  // namespace
}  // namespace ddssec::rtps
