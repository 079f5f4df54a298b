#include "plugins/cryptography/builtin_checks.hpp"

#include <algorithm>
#include <array>

#include "plugins/cryptography/data_piece.hpp"

namespace ddssec::cryptography {
namespace {

/// Parameters that name a participant or one of its entities by a GUID (RTPS 9.6.3).
namespace parameter_id {
constexpr std::uint16_t kParticipantGuid = 0x0050, kEndpointGuid = 0x005a, kKeyHash = 0x0070,
                        kCycloneTopicGuid = 0x801b;
}  // namespace parameter_id

/// How the samples of a builtin writer name what they are about.
struct Topic {
  EntityId writer;
  std::uint16_t key;  ///< its parameter; 0: ParticipantMessageData, which has none
};
constexpr std::array kTopics = {
    Topic{{{0x00, 0x01, 0x00, 0xc2}}, parameter_id::kParticipantGuid},
    Topic{{{0xff, 0x01, 0x01, 0xc2}}, parameter_id::kParticipantGuid},
    Topic{{{0x00, 0x00, 0x03, 0xc2}}, parameter_id::kEndpointGuid},
    Topic{{{0xff, 0x00, 0x03, 0xc2}}, parameter_id::kEndpointGuid},
    Topic{{{0x00, 0x00, 0x04, 0xc2}}, parameter_id::kEndpointGuid},
    Topic{{{0xff, 0x00, 0x04, 0xc2}}, parameter_id::kEndpointGuid},
    Topic{{{0x00, 0x00, 0x02, 0xc2}}, parameter_id::kCycloneTopicGuid},
    Topic{{{0x00, 0x02, 0x00, 0xc2}}, 0},
    Topic{{{0xff, 0x02, 0x00, 0xc2}}, 0},
};

constexpr std::string_view kDocument = "a discovery or liveliness message";
constexpr std::size_t kEncapsulationSize = 4;

const Topic* topic_of(const EntityId& writer) {
  constexpr std::uint8_t kBuiltinKeyedWriter = 0xc2;
  if (writer.octets[3] != kBuiltinKeyedWriter) return nullptr;
  const auto found = std::ranges::find(kTopics, writer, &Topic::writer);
  return found == kTopics.end() ? nullptr : &*found;
}

/// Collects what one message says.
class Names {
 public:
  Names(const Topic& topic, const GuidPrefix& owner) : topic_(topic), owner_(owner) {}

  Status check(std::string_view field, BytesView name) {
    if (name.size() < GuidPrefix::size) return unreadable("a GUID is too short");
    const auto found = GuidPrefix::from(name.first(GuidPrefix::size));
    if (found == owner_) return {};
    return fail(Code::builtin_source_mismatch, {.document = std::string(kDocument),
                                                .field = std::string(field),
                                                .expected = owner_.to_string(),
                                                .found = found.to_string(),
                                                .note = "by writer " + topic_.writer.to_string()});
  }

  Status unreadable(std::string_view why) const {
    return fail(Code::builtin_source_unreadable,
                {.document = std::string(kDocument),
                 .note = std::string(why) + ", by writer " + topic_.writer.to_string()});
  }

  Status check_inline_qos(const DataPiece& piece) {
    Reader in(piece.inline_qos, piece.endian);
    while (!in.at_end()) {
      const auto parameter = next_parameter(in);
      if (!parameter || !*parameter) return {};  // read once already
      if ((*parameter)->id == parameter_id::kKeyHash)
        DDSSEC_TRY(check("key hash", (*parameter)->value));
    }
    return {};
  }

  /// ParticipantMessageData, or its key: both begin with the prefix. Fast DDS calls the same octets
  /// PL_CDR.
  Status check_liveliness(BytesView payload) {
    constexpr std::uint8_t kGreatestPlain = 3;
    if (payload.size() < kEncapsulationSize + GuidPrefix::size)
      return unreadable("it is too short");
    if (payload[0] != 0 || payload[1] > kGreatestPlain)
      return unreadable("its encapsulation is not CDR");
    return check("participantGuidPrefix", payload.subspan(kEncapsulationSize));
  }

  Status check_parameters(const DataPiece& piece) {
    const auto payload = piece.payload;
    constexpr std::uint8_t kBig = 2, kLittle = 3;
    if (payload.size() < kEncapsulationSize) return unreadable("it is too short");
    if (payload[0] != 0 || (payload[1] != kBig && payload[1] != kLittle))
      return unreadable("its encapsulation is not a parameter list");
    Reader in(payload.subspan(kEncapsulationSize),
              payload[1] == kLittle ? Endian::little : Endian::big);
    for (;;) {
      const auto parameter = next_parameter(in);
      // The rest of a fragmented list comes later.
      if (!parameter && piece.is_fragment && has_key_) return {};
      if (!parameter) return unreadable("its parameters have lengths that lie");
      if (!*parameter) break;
      DDSSEC_TRY(check_parameter(**parameter));
    }
    return has_key_ || (has_name_ && !piece.is_fragment) ? Status()
                                                         : unreadable("it names nothing");
  }

 private:
  Status check_parameter(const Parameter& one) {
    const bool is_key = one.id == topic_.key;
    const auto field = one.id == parameter_id::kParticipantGuid ? "PID_PARTICIPANT_GUID"
                       : one.id == parameter_id::kEndpointGuid  ? "PID_ENDPOINT_GUID"
                       : one.id == parameter_id::kKeyHash       ? "PID_KEY_HASH"
                       : is_key                                 ? "PID_CYCLONE_TOPIC_GUID"
                                                                : nullptr;
    if (field == nullptr) return {};
    has_key_ = has_key_ || is_key;
    has_name_ = true;
    return check(field, one.value);
  }

  const Topic& topic_;
  const GuidPrefix& owner_;
  bool has_key_ = false;
  bool has_name_ = false;
};

}  // namespace

Status check_builtin_source(BytesView submessage, const GuidPrefix& owner) {
  const auto writer = writer_of_data(submessage);
  if (!writer) return {};
  const auto* const topic = topic_of(*writer);
  if (topic == nullptr) return {};
  Names names(*topic, owner);
  const auto piece = read_data_piece(submessage);
  if (!piece) return names.unreadable("its lengths contradict one another");
  DDSSEC_TRY(names.check_inline_qos(*piece));
  if (!piece->begins_sample || (!piece->has_data && !piece->has_key)) return {};
  return topic->key == 0 ? names.check_liveliness(piece->payload) : names.check_parameters(*piece);
}

}  // namespace ddssec::cryptography
