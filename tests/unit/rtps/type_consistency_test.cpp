// Types and keys that differ.
#include "rtps/types/type_consistency.hpp"

#include <chrono>

#include <gmock/gmock.h>

#include "base/writer.hpp"
#include "tests/unit/rtps/participant_fixture.hpp"
#include "tests/unit/rtps/participants.hpp"

namespace ddssec::rtps::participants {
namespace {

using testing::socketless::Node;
using testing::socketless::World;

EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }

EquivalenceHash hash_of(std::uint8_t side, std::uint8_t level) {
  EquivalenceHash out{side, level};
  return out;
}

Bytes identifier_of(const EquivalenceHash& hash) {
  Writer out;
  out.write(std::uint8_t{0xf1});
  out.write_bytes(hash);
  return out.take();
}

void write_delimited(Writer& out, BytesView octets) {
  out.align(4);
  out.write(static_cast<std::uint32_t>(octets.size()));
  out.write_bytes(octets);
}

// A minimal structure with `count` members of that type.
Bytes structure_of(std::size_t count, BytesView type) {
  Writer out(Endian::little);
  out.write_bytes(std::array<std::uint8_t, 4>{0xf1, 0x51, 1, 0});  // final
  write_delimited(out, {});
  out.write(std::uint32_t{0});
  out.write(static_cast<std::uint32_t>(count));
  for (std::uint32_t id = 0; id < count; ++id) {
    Writer member(Endian::little);
    member.write(id);
    member.write(std::uint16_t{0});
    member.write_bytes(type);
    member.write(id);  // the hash of its name
    write_delimited(out, member.view());
  }
  return out.take();
}

// Returns a type of as many levels. Each has `width` members, which have the type of the next
// level.
TypeDescription nested_type(std::uint8_t side, std::uint8_t levels, std::size_t width) {
  Writer objects(Endian::little);
  objects.write(std::uint32_t{0});
  objects.write(std::uint32_t{levels});
  for (std::uint8_t level = 0; level < levels; ++level) {
    const auto next = static_cast<std::uint8_t>(level + 1);
    const auto type = next == levels ? Bytes{4} : identifier_of(hash_of(side, next));
    objects.write_bytes(identifier_of(hash_of(side, level)));
    write_delimited(objects, structure_of(width, type));
  }
  Writer with_size(Endian::little), with_dependencies(Endian::little), member(Endian::little),
      information(Endian::little);
  write_delimited(with_size, identifier_of(hash_of(side, 0)));
  write_delimited(with_dependencies, with_size.view());
  member.write(std::uint32_t{0x40001001});
  write_delimited(member, with_dependencies.view());
  write_delimited(information, member.view());
  return {information.take(), objects.take()};
}

TEST(JudgeTypes, StructuresThatContainEachOtherOften_AreComparedOnce) {
  const auto writer = nested_type(1, 12, 6), reader = nested_type(2, 12, 6);
  ASSERT_LE(writer.objects.size(), kMaxTypeObjects);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(judge_types(writer, reader).verdict, TypeVerdict::assignable);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(1));
}

TEST(Participant, OtherTypesAndKeys_AreNamed) {
  for (auto other : {EndpointDescription{"Square", "Other", default_reader_qos(), true},
                     EndpointDescription{"Square", "ShapeType", default_reader_qos(), false}}) {
    Node a(1), b(2);
    World world{{&a, &b}};
    ASSERT_TRUE(a.participant.create_writer(square(default_writer_qos()), a.listener, world.now));
    ASSERT_TRUE(b.participant.create_reader(other, b.listener, world.now));
    world.run();
    EXPECT_THAT(a.events.codes(), ::testing::ElementsAre(Code::rtps_type_mismatch));
    EXPECT_EQ(a.listener.matched, 0);
    EXPECT_EQ(a.listener.inconsistent, 1);
  }
}

}  // namespace
}  // namespace ddssec::rtps::participants
