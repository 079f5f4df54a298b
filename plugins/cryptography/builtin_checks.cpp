#include "plugins/cryptography/builtin_checks.hpp"

#include "plugins/cryptography/builtin_names.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "wire/entity_ids.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::size_t kEncapsulationSize = 4;
constexpr std::size_t kGuidSize = GuidPrefix::size + EntityId::size;  // the size of a key hash, too

// StatusInfo_t (RTPS 9.6.4.9): disposed, or unregistered.
constexpr std::uint8_t kDisposedOrUnregistered = 3;
bool says_end(BytesView status_info) {
  return status_info.size() >= 4 && (status_info[3] & kDisposedOrUnregistered) != 0;
}

// What the inline QoS of a sample says about the subject of the sample.
enum class Ending : std::uint8_t {
  none,
  usual,    // disposed or unregistered, in the form that all products write
  unusual,  // disposed or unregistered, but the host may refuse the form and keep the subject
};

// Collects the parameters of inline QoS, to tell the usual form: one StatusInfo_t without unknown
// bits, and at most one key hash.
struct InlineForm {
  bool ends = false;
  bool is_usual = true;
  std::size_t status_infos = 0, key_hashes = 0;

  void note(const rtps::Parameter& parameter) {
    const auto& value = parameter.value;
    if (parameter.id == pid::kStatusInfo) {
      const bool is_known = value.size() == 4 && value[0] == 0 && value[1] == 0 && value[2] == 0 &&
                            value[3] <= kDisposedOrUnregistered;
      is_usual = is_usual && is_known && ++status_infos == 1;
    } else if (parameter.id == pid::kKeyHash) {
      is_usual = is_usual && value.size() == kGuidSize && ++key_hashes == 1;
    } else {
      is_usual = false;
    }
  }
  Ending ending() const {
    return !ends ? Ending::none : is_usual ? Ending::usual : Ending::unusual;
  }
};

// A repeated StatusInfo with another meaning is refused, because it is not known here which one
// the host uses.
Result<Ending> check_inline_qos(const DiscoveryTopic& topic, const Owner& owner,
                                const DataPiece& piece) {
  rtps::ParameterReader list(piece.inline_qos, piece.endian);
  InlineForm form;
  while (!list.at_end()) {
    const auto parameter = list.next_or_pad();
    if (!parameter || !*parameter) break;  // it was read once already
    if (is_deprecated_address((*parameter)->id))
      return unreadable_name_error(topic, "it has an address in the form of RTPS 1");
    if ((*parameter)->id == pid::kKeyHash)
      DDSSEC_RETURN_IF_ERROR(check_name(topic, owner, "key hash", (*parameter)->value));
    if ((*parameter)->id == pid::kStatusInfo) {
      const bool says = says_end((*parameter)->value);
      if (form.status_infos > 0 && form.ends != says)
        return unreadable_name_error(topic, "it has two values of PID_STATUS_INFO");
      form.ends = says;
    }
    form.note(**parameter);
  }
  return form.ending();
}

// Success if the inline QoS of a sample of any other writer has nothing that ends the host.
Status check_other_inline_qos(BytesView submessage) {
  constexpr std::uint8_t kInlineQosFlag = 2;
  if ((submessage[1] & kInlineQosFlag) == 0) return {};
  const auto inline_qos_error = [](std::string_view why) {
    return fail(Code::inline_qos_refused, {.document = "a sample", .note = std::string(why)});
  };
  const auto piece = read_data_piece(submessage);
  if (!piece) return inline_qos_error("its lengths contradict one another");
  rtps::ParameterReader list(piece->inline_qos, piece->endian);
  while (!list.at_end()) {
    const auto parameter = list.next_or_pad();
    if (!parameter || !*parameter) break;  // it was read once already
    if (is_deprecated_address((*parameter)->id))
      return inline_qos_error("it has an address in the form of RTPS 1");
  }
  return {};
}

// Checks ParticipantMessageData or its key: both begin with the prefix. Fast DDS labels the same
// octets as PL_CDR.
Status check_liveliness(const DiscoveryTopic& topic, const Owner& owner, BytesView payload) {
  constexpr std::uint8_t kMaxPlain = 3;
  if (payload.size() < kEncapsulationSize + GuidPrefix::size)
    return unreadable_name_error(topic, "it is too short");
  if (payload[0] != 0 || payload[1] > kMaxPlain)
    return unreadable_name_error(topic, "its encapsulation is not CDR");
  return check_name(topic, owner, "participantGuidPrefix", payload.subspan(kEncapsulationSize));
}

// An end counts only in the form that no host refuses. A host that refuses an end acknowledges it,
// but keeps the endpoint.
Announcement::Kind kind_of(Ending ending, const ParameterWalk& walk) {
  if (ending == Ending::none) return Announcement::Kind::announces;
  return ending == Ending::usual && walk.has_only_names() ? Announcement::Kind::ends
                                                          : Announcement::Kind::nothing;
}

// Checks a sample that is in one piece. `announced` is nullptr if the owner of the announcement is
// not known.
Result<TypeInformationAt> check_whole(const DiscoveryTopic& topic, const Owner& owner,
                                      const DataPiece& piece, Ending ending,
                                      AnnouncedEndpoints* announced) {
  if (topic.key == 0) {
    DDSSEC_RETURN_IF_ERROR(check_liveliness(topic, owner, piece.payload));
    return TypeInformationAt{};
  }
  ParameterWalk walk;
  DDSSEC_RETURN_IF_ERROR(walk.read(topic, owner, piece.payload));
  DDSSEC_RETURN_IF_ERROR(walk.check_end(topic));
  if (announced != nullptr)
    DDSSEC_RETURN_IF_ERROR(
        announced->note(topic, {piece.number, kind_of(ending, walk), walk.entity(),
                                walk.cost(piece.payload.size()), !walk.says_protection()}));
  return walk.type_information();
}

Result<TypeInformationAt> check_payload(const DiscoveryTopic& topic, const Owner& owner,
                                        const DataPiece& piece, Ending ending, PeerDiscovery* peer,
                                        MonotonicTime now) {
  auto* const announced = peer == nullptr ? nullptr : &peer->announced;
  if (!piece.is_fragment) return check_whole(topic, owner, piece, ending, announced);
  if (piece.payload.size() < piece.fragments_size)
    return unreadable_name_error(topic, "a fragment is shorter than it says");
  if (piece.payload.size() == piece.sample_size)
    return check_whole(topic, owner, piece, ending, announced);
  if (topic.key == 0) return unreadable_name_error(topic, "it is in fragments");
  return peer == nullptr ? fail(Code::builtin_fragment_early)
                         : peer->walks.check(topic, owner, piece, peer->announced, now);
}

// The host reads nothing of such a sample and continues with the next number.
Status check_without_payload(const DiscoveryTopic& topic, const DataPiece& piece,
                             PeerDiscovery* peer) {
  if (peer == nullptr) return {};
  return peer->announced.note(topic, {.number = piece.number});
}

// Returns the announcing peer; nullptr if it is not known, or if samples of this topic announce
// nothing.
PeerDiscovery* announcer(const DiscoveryTopic& topic, const Owner& owner, DiscoveryOfPeers& peers) {
  return topic.key == 0 ? nullptr : peers.of(owner.value_or(GuidPrefix{}));
}

// True for a writer that announces endpoints under a key of its own. Announcements in the clear are
// not delayed, because an attacker may have sent them in the peer's name.
bool announces_securely(const DiscoveryTopic& topic) {
  return topic.writer == rtps::kPublicationsSecureWriter ||
         topic.writer == rtps::kSubscriptionsSecureWriter;
}

// Charges the work of endpoints that were announced again.
void charge_changes(PeerDiscovery* peer, MonotonicTime now) {
  if (peer == nullptr) return;
  for (auto repeats = peer->announced.take_repeats(); repeats > 0; --repeats)
    peer->work.note_change(now);
}

// Records the numbers that the host skips from now on.
void note_skipped(BytesView submessage, const Owner& owner, DiscoveryOfPeers& peers) {
  const auto skipped = read_skipped(submessage);
  const auto* const topic = skipped ? discovery_topic_of(skipped->writer) : nullptr;
  auto* const peer = topic == nullptr ? nullptr : announcer(*topic, owner, peers);
  if (peer == nullptr) return;
  for (const auto& [begin, end] : skipped->ranges) peer->announced.skip(*topic, begin, end);
}

}  // namespace

Result<TypeInformationAt> check_builtin_source(BytesView submessage, const Owner& owner,
                                               DiscoveryOfPeers& peers) {
  const auto writer = writer_of_data(submessage);
  if (!writer) {
    note_skipped(submessage, owner, peers);
    return TypeInformationAt{};
  }
  const auto* const topic = discovery_topic_of(*writer);
  // Without a known owner, the name in a liveliness message cannot be checked.
  if (topic == nullptr || (topic->key == 0 && !owner)) {
    DDSSEC_RETURN_IF_ERROR(check_other_inline_qos(submessage));
    return TypeInformationAt{};
  }
  auto* const peer = announcer(*topic, owner, peers);
  if (peer != nullptr && announces_securely(*topic))
    DDSSEC_RETURN_IF_ERROR(peer->work.check(peers.now()));
  const auto piece = read_data_piece(submessage);
  if (!piece) return unreadable_name_error(*topic, "its lengths contradict one another");
  DDSSEC_ASSIGN_OR_RETURN(const auto ending, check_inline_qos(*topic, owner, *piece));
  if (!piece->has_data && !piece->has_key) {
    DDSSEC_RETURN_IF_ERROR(check_without_payload(*topic, *piece, peer));
    return TypeInformationAt{};
  }
  DDSSEC_ASSIGN_OR_RETURN(auto at, check_payload(*topic, owner, *piece, ending, peer, peers.now()));
  charge_changes(peer, peers.now());
  if (at) at->at += static_cast<std::uint32_t>(piece->payload.data() - submessage.data());
  return at;
}

}  // namespace ddssec::cryptography
