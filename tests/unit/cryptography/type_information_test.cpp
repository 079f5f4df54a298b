// PID_TYPE_INFORMATION: what products announce passes, what ends Cyclone DDS 0.10.2 does not.
#include "plugins/cryptography/type_information.hpp"

#include <gtest/gtest.h>

#include "plugins/cryptography/builtin_checks.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}};
constexpr EntityId kListWriters[] = {{{0, 1, 0, 0xc2}}, {{0xff, 1, 1, 0xc2}},
                                     {{0, 0, 3, 0xc2}}, {{0xff, 0, 3, 0xc2}},
                                     {{0, 0, 4, 0xc2}}, {{0xff, 0, 4, 0xc2}}};
constexpr std::uint16_t kTypeInformation = 0x75;
constexpr std::uint8_t kMinimal = 0xf1, kComplete = 0xf2;

/// XCDR2 with every length in its place.
class Xcdr2 {
 public:
  explicit Xcdr2(bool little) : little_(little) {}
  void word(std::uint32_t value) { append(octets, value, 4, little_); }
  void id(std::uint8_t kind) {
    octets.push_back(kind);
    octets.resize(octets.size() + 15, 0x5a);
  }
  /// What `content` writes, after its size.
  template <class F>
  void sized(F&& content) {
    Xcdr2 inner(little_);
    content(inner);
    word(static_cast<std::uint32_t>(inner.octets.size()));
    append(octets, inner.octets);
  }
  Bytes octets;

 private:
  bool little_;
};

struct Form {
  bool little = true;
  std::uint8_t minimal = kMinimal, complete = kComplete;
  std::vector<std::uint8_t> minimal_list = {kMinimal, kMinimal}, complete_list = {kComplete};
  bool delimited = false;  ///< length code 5
  bool is_swapped = false;
  bool is_halved = false;
};

void append_identifier(Xcdr2& out, std::uint8_t kind) {
  out.sized([&](Xcdr2& in) {
    if (kind == 0) {
      in.word(0);
    } else {
      in.id(kind);
    }
    in.word(77);
  });
}

void append_half(Xcdr2& out, const Form& form, bool is_complete) {
  const auto body = [&](Xcdr2& in) {
    const auto& list = is_complete ? form.complete_list : form.minimal_list;
    append_identifier(in, is_complete ? form.complete : form.minimal);
    in.word(static_cast<std::uint32_t>(list.size()));
    in.sized([&](Xcdr2& items) {
      items.word(static_cast<std::uint32_t>(list.size()));
      for (const auto kind : list) append_identifier(items, kind);
    });
  };
  const std::uint32_t id = is_complete ? 0x1002 : 0x1001;
  out.word((form.delimited ? 0x50000000 : 0x40000000) | id);
  if (form.delimited)
    out.sized(body);
  else
    out.sized([&](Xcdr2& in) { in.sized(body); });
}

Bytes of(const Form& form) {
  Xcdr2 out(form.little);
  out.sized([&](Xcdr2& in) {
    append_half(in, form, form.is_swapped);
    if (!form.is_halved) append_half(in, form, !form.is_swapped);
  });
  return out.octets;
}

void append_parameter(Bytes& out, std::uint16_t id, BytesView value, bool little) {
  append(out, id, 2, little);
  append(out, value.size(), 2, little);
  append(out, value);
}

/// An announcement of the peer's.
Bytes announcement(const std::vector<Bytes>& types, bool little = true) {
  auto guid = to_bytes(kPeer.view());
  append(guid, Bytes{0, 0, 1, 2});
  Bytes out = {0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
  append_parameter(out, 0x05, Bytes(12, 0x50), little);
  for (const auto& type : types) append_parameter(out, kTypeInformation, type, little);
  append_parameter(out, 0x50, guid, little);
  append_parameter(out, 0x5a, guid, little);
  append_parameter(out, 1, {}, little);
  return out;
}

Code code(const EntityId& writer, const Bytes& payload) {
  OneOwner walks;
  const DataMessage message{.writer = writer, .payload = payload};
  return code_of(check_builtin_source(message.octets(), kPeer, walks));
}
Code code(const Bytes& type, bool little = true) {
  return code(kPublications, announcement({type}, little));
}
constexpr Code kRefused = Code::builtin_source_unreadable;

/// By Cyclone DDS 0.10.2, of a type with one nested type.
const Bytes kOfCyclone = *from_hex(
    "9000000001100040400000003c00000014000000f109495c3e89212499bdd51d42883a004a000000"
    "010000001c0000000100000014000000f1badd950039ac78588aaa107a73bf0027000000"
    "02100040400000003c00000014000000f25310de9d6e1b432121ec8b16b8d50063000000"
    "010000001c0000000100000014000000f2650aa64f21fd6e5d4e2f1791d7d50038000000");
/// By Fast DDS 2.9.1: plain CDR, after an encapsulation.
const Bytes kOfFastDds = *from_hex(
    "00010000f11112131415161718191a1b1c1d1e004d000000ffffffff00000000"
    "f23132333435363738393a3b3c3d3e4163000000ffffffff00000000");

TEST(TypeInformation, OfProductsPasses) {
  EXPECT_EQ(code(kOfCyclone), Code{});
  EXPECT_EQ(code(kOfFastDds), Code{});  // Cyclone DDS refuses it without harm
  for (const bool little : {true, false})
    for (const bool delimited : {true, false})
      for (const auto& list : {std::vector<std::uint8_t>{}, {kMinimal}, {kMinimal, kMinimal}})
        EXPECT_EQ(
            code(of({.little = little, .minimal_list = list, .delimited = delimited}), little),
            Code{});
}

TEST(TypeInformation, OfWhichOneHalfIsMissingByNamePasses) {  // OpenDDS announces minimal only
  EXPECT_EQ(code(of({.complete = 0, .complete_list = {}})), Code{});
  EXPECT_EQ(code(of({.minimal = 0, .minimal_list = {}})), Code{});
}

TEST(TypeInformation, OfAnyOtherKindIsRefusedByEachWriterInBothOrders) {
  for (const bool little : {true, false})
    for (const auto& writer : kListWriters)
      for (int kind = 0; kind < 256; ++kind) {
        const auto octet = static_cast<std::uint8_t>(kind);
        const auto check = [&](const Form& form) {
          return code(writer, announcement({of(form)}, little));
        };
        if (octet != kMinimal && octet != 0) {
          EXPECT_EQ(check({.little = little, .minimal = octet}), kRefused) << kind;
          EXPECT_EQ(check({.little = little, .minimal_list = {kMinimal, octet}}), kRefused) << kind;
        }
        if (octet != kComplete && octet != 0) {
          EXPECT_EQ(check({.little = little, .complete = octet}), kRefused) << kind;
          EXPECT_EQ(check({.little = little, .complete_list = {octet}}), kRefused) << kind;
        }
      }
  EXPECT_EQ(code(of({.minimal_list = {0}})), kRefused);
}

TEST(TypeInformation, OneOctetElsewhereNeverMakesAnotherFormPass) {
  // Hashes with their padding, sizes of type objects, and counts may be anything.
  const auto may_change = [](std::size_t at) {
    const auto within = at < 4 ? at : (at - 4) % 72;  // of a half
    return at >= 4 && ((within >= 17 && within < 40) || (within >= 53 && within < 72));
  };
  for (std::size_t at = 0; at < kOfCyclone.size(); ++at)
    for (int value = 0; value < 256; ++value) {
      auto changed = kOfCyclone;
      changed[at] = static_cast<std::uint8_t>(value);
      const bool same = changed == kOfCyclone;
      const bool is_flag = (at == 7 || at == 79) && value == 0xc0;  // must understand
      const bool is_too_large = at < 4 && changed > kOfCyclone && value > kOfCyclone[at];
      EXPECT_EQ(code(changed),
                same || is_flag || is_too_large || may_change(at) ? Code{} : kRefused)
          << at << " " << value;
    }
}

TEST(TypeInformation, InAnotherOrderOrHalfOrTwiceIsRefused) {
  EXPECT_EQ(code(of({.is_swapped = true})), kRefused);
  EXPECT_EQ(code(of({.is_halved = true})), kRefused);
  EXPECT_EQ(code({}), kRefused);
  EXPECT_EQ(code(Bytes(4, 0)), kRefused);
  EXPECT_EQ(code(kPublications, announcement({of({}), of({})})), kRefused);
  auto longer = of({});
  longer.resize(longer.size() + 4, 0);
  EXPECT_EQ(code(longer), kRefused);
}

TEST(TypeInformation, CutOffIsRefused) {
  for (std::size_t size = 0; size < kOfCyclone.size(); size += 4) {
    Bytes cut(kOfCyclone.begin(), kOfCyclone.begin() + static_cast<std::ptrdiff_t>(size));
    if (size >= 4) {  // its size has to agree, otherwise it is none that Cyclone DDS reads
      EXPECT_EQ(code(cut), Code{}) << size;
      cut[0] = static_cast<std::uint8_t>(size - 4);
    }
    EXPECT_EQ(code(cut), kRefused) << size;
  }
}

/// The code of a sample in fragments of that size.
Code in_fragments(const Bytes& sample, std::uint16_t size) {
  OneOwner walks;
  std::uint32_t number = 1;
  for (std::size_t from = 0; from < sample.size(); from += size, ++number) {
    const auto to = std::min(from + size, sample.size());
    const DataMessage message{
        .writer = kPublications,
        .flags = 0,
        .payload = Bytes(sample.begin() + static_cast<std::ptrdiff_t>(from),
                         sample.begin() + static_cast<std::ptrdiff_t>(to)),
        .fragment = Fragment{
            .first = number, .size = size, .whole = static_cast<std::uint32_t>(sample.size())}};
    const auto code = code_of(check_builtin_source(message.octets(), kPeer, walks));
    if (code != Code{}) return code;
  }
  return {};
}

TEST(TypeInformation, InFragmentsIsJudgedTheSame) {
  const auto honest = announcement({kOfCyclone});
  const auto hostile = announcement({of({.complete = 0x82})});
  for (std::uint16_t size = 4; size < honest.size(); ++size) {
    EXPECT_EQ(in_fragments(honest, size), Code{}) << size;
    EXPECT_EQ(in_fragments(hostile, size), kRefused) << size;
  }
}

TEST(TypeInformation, TheErrorSaysWhatAndByWhom) {
  OneOwner walks;
  const DataMessage message{.writer = kPublications,
                            .payload = announcement({of({.minimal = 0x82})})};
  const auto status = check_builtin_source(message.octets(), kPeer, walks);
  ASSERT_EQ(code_of(status), kRefused);
  EXPECT_NE(status.error().to_sentence().find("type information"), std::string::npos);
  EXPECT_NE(status.error().to_sentence().find("ff0003c2"), std::string::npos);
}

}  // namespace
}  // namespace ddssec::cryptography
