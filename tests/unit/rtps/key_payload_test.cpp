// The payload of a dispose or unregister. Three ways to write the key of an appendable type in
// XCDR2 are in use, and a reader must get the same key from all of them.
#include "rtps/reliability/key_payload.hpp"

#include "rtps/cdr/cdr_reader.hpp"
#include "rtps/cdr/key_hash.hpp"
#include "rtps/dcps/type_support.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::rtps {

struct Alarm {
  std::string name;
  std::int32_t number = 0;
  std::int32_t value = 0;
  bool operator==(const Alarm&) const = default;
};
template <>
struct TypeTraits<Alarm> {
  static constexpr std::string_view type_name = "Alarm";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.name, 30), s.value, key(s.number));
  }
};

struct Site {
  std::string note;
  std::uint16_t id = 0;
  bool operator==(const Site&) const = default;
};
template <>
struct TypeTraits<Site> {
  static constexpr std::string_view type_name = "Site";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.note, key(s.id));
  }
};

struct Device {
  Site site;
  std::int64_t serial = 0;
  bool operator==(const Device&) const = default;
};
template <>
struct TypeTraits<Device> {
  static constexpr std::string_view type_name = "Device";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.site), key(s.serial));
  }
};

struct Colour4 {
  std::string color;
  std::int32_t x = 0;
  bool operator==(const Colour4&) const = default;
};
template <>
struct TypeTraits<Colour4> {
  static constexpr std::string_view type_name = "ShapeType";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.color, 128), s.x);
  }
};

namespace {

using testing::code_of;

const Alarm kAlarm{"fire", 7, 0};
const Device kDevice{{"", 3}, 9};

struct Form {
  const char* what;
  const char* alarm;
  const char* device;
};
// The first form is that of XTypes 1.3, 7.6.3.4 and 7.4.3.5: D_CDR2 (0x0009) with a DHEADER for the
// key holder and for each appendable struct in it, which Cyclone DDS writes since PR 1750. The
// second one was recorded from Cyclone DDS 0.10.2: D_CDR2 without DHEADERs. The third one is
// PLAIN_CDR2 (0x0007), which earlier versions of ddssec wrote.
const Form kForms[] = {
    {"with DHEADERs",
     "00090000"
     "10000000"
     "0500000066697265"
     "00000000"
     "07000000",
     "00090000"
     "10000000"
     "02000000"
     "0300"
     "0000"
     "0900000000000000"},
    {"Cyclone DDS 0.10",
     "00090000"
     "0500000066697265"
     "00000000"
     "07000000",
     "00090000"
     "0300"
     "0000"
     "0900000000000000"},
    {"PLAIN_CDR2",
     "00070000"
     "0500000066697265"
     "00000000"
     "07000000",
     "00070000"
     "0300"
     "0000"
     "0900000000000000"},
};

Bytes octets_of(const char* hex) { return *from_hex(hex); }

TEST(KeyPayload, AllThreeForms_NameTheSameInstance) {
  for (const auto& form : kForms) {
    EXPECT_EQ(deserialize_key<Alarm>(octets_of(form.alarm)), kAlarm) << form.what;
    EXPECT_EQ(deserialize_key<Device>(octets_of(form.device)), kDevice) << form.what;
    for (bool big : {false, true}) {
      Bytes out;
      serialize_key(kDevice, out, XcdrVersion::xcdr2, big ? Endian::big : Endian::little);
      EXPECT_EQ(deserialize_key<Device>(out), kDevice);
    }
  }
}

TEST(KeyPayload, WhatIsWritten_HasADHeaderForEachAppendableType) {
  Bytes out;
  serialize_key(kAlarm, out, XcdrVersion::xcdr2);
  EXPECT_EQ(out, octets_of(kForms[0].alarm));
  serialize_key(kDevice, out, XcdrVersion::xcdr2);
  EXPECT_EQ(out, octets_of(kForms[0].device));
  serialize_key(kDevice, out, XcdrVersion::xcdr2, Endian::little, KeyLayout::bare);
  EXPECT_EQ(out, octets_of(kForms[1].device));
  serialize_key(kAlarm, out, XcdrVersion::xcdr1);
  EXPECT_EQ(to_hex(BytesView(out).first(4)), "00010000");
  EXPECT_EQ(deserialize_key<Alarm>(out), kAlarm);
}

TEST(KeyPayload, PaddingAtTheEnd_IsNoMember) {
  Bytes out;
  for (const auto layout : {KeyLayout::delimited, KeyLayout::bare}) {
    for (std::size_t length = 0; length < 9; ++length) {
      const Colour4 shape{std::string(length, 'x'), 0};
      serialize_key(shape, out, XcdrVersion::xcdr2, Endian::little, layout);
      EXPECT_EQ(deserialize_key<Colour4>(out), shape);
      out[3] = 0;  // as from a peer that does not count its padding
      EXPECT_EQ(deserialize_key<Colour4>(out), shape);
    }
  }
}

// A truncated key with DHEADERs may be a whole key without them, but never the same one.
TEST(KeyPayload, EveryTruncation_IsRefusedOrAnotherKey) {
  for (const auto& form : kForms) {
    const auto alarm = octets_of(form.alarm), device = octets_of(form.device);
    for (std::size_t size = 0; size < alarm.size(); ++size) {
      const auto read = deserialize_key<Alarm>(BytesView(alarm).first(size));
      ASSERT_FALSE(read) << form.what << ' ' << size;
      EXPECT_TRUE(code_of(read) == Code::truncated || code_of(read) == Code::malformed);
    }
    for (std::size_t size = 0; size < device.size(); ++size)
      EXPECT_NE(deserialize_key<Device>(BytesView(device).first(size)), kDevice) << size;
  }
}

TEST(KeyPayload, WhatIsLeftOver_IsRefusedAndSoIsALyingDHeader) {
  for (const auto& form : kForms) {
    auto longer = octets_of(form.alarm);
    longer.insert(longer.end(), 8, 0);
    EXPECT_EQ(code_of(deserialize_key<Alarm>(longer)), Code::malformed) << form.what;
  }
  for (int size = 0; size < 256; ++size) {
    auto lying = octets_of(kForms[0].alarm);
    if (std::exchange(lying[4], static_cast<std::uint8_t>(size)) == lying[4]) continue;
    EXPECT_FALSE(deserialize_key<Alarm>(lying)) << size;
  }
}

TEST(KeyPayload, AFinalType_HasNoDHeader) {
  EXPECT_EQ(code_of(deserialize_key<Colour4>(octets_of("000900000500000066697265000000"))),
            Code::rtps_encapsulation_unsupported);
  EXPECT_EQ(code_of(deserialize_key<Colour4>(octets_of("000300000500000066697265000000"))),
            Code::rtps_encapsulation_unsupported);
}

TEST(KeyPayload, ReadersOfCyclone010_GetNoDHeader) {
  const auto support = type_support<Device>();
  const auto ours = octets_of(kForms[0].device);
  Bytes scratch;
  EXPECT_EQ(to_hex(key_payload_for({.bare_only = true}, ours, support.bare_key, scratch)),
            kForms[1].device);
  EXPECT_EQ(to_hex(key_payload_for({}, ours, support.bare_key, scratch)), kForms[0].device);
  EXPECT_EQ(to_hex(key_payload_for({.bare_only = true}, ours, nullptr, scratch)), kForms[0].device);
  const Bytes garbage = {0, 9, 0, 0, 1, 2};
  EXPECT_EQ(to_hex(key_payload_for({.bare_only = true}, garbage, support.bare_key, scratch)),
            to_hex(garbage));
}

TEST(KeyPayload, ReadersOfFastDds2_GetMoreThanAKeyHash) {
  Bytes out, scratch;
  for (std::size_t length = 0; length < 20; ++length) {
    const Colour4 shape{std::string(length, 'x'), 0};
    serialize_key(shape, out);
    const auto sent = key_payload_for({.short_is_hash = true}, out, nullptr, scratch);
    EXPECT_GT(sent.size(), 16u);
    EXPECT_EQ(deserialize_key<Colour4>(sent), shape);
    if (out.size() > 16) {
      EXPECT_EQ(to_hex(sent), to_hex(out));
    }
    EXPECT_EQ(to_hex(key_payload_for({}, out, nullptr, scratch)), to_hex(out));
  }
}

TEST(VendorVersionNumbers, OnlyTheFirstTwoNumbers_AreCompared) {
  for (const auto* version : {"0.10.2", "0.10", "0.9.1", "0.10-beta"})
    EXPECT_TRUE(is_up_to(version, 0, 10)) << version;
  for (const auto* version : {"0.11.0", "1.0", "11.0.1", "", ".", "0", "0.", "x", "-1.2"})
    EXPECT_FALSE(is_up_to(version, 0, 10)) << version;
}

}  // namespace
}  // namespace ddssec::rtps
