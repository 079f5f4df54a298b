#include "rtps/security/handshake_sender.hpp"

#include <algorithm>

#include "wire/acknack.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps {
namespace {

// The size of a message without its payload: the RTPS header, INFO_DST, and DATA.
constexpr std::size_t kHeaders = 64;

}  // namespace

std::size_t HandshakeSender::send(const Peer& peer, const GenericMessage& message,
                                  const LocatorList& addresses) {
  const auto payload = write_generic_message(message);
  const auto size = payload.size() + kHeaders;
  if (size > sender_.amplification_limit().left(peer.prefix(), addresses)) return size;
  sender_.add({peer.prefix(), addresses}, Data{kStatelessMessageReader,
                                               kStatelessMessageWriter,
                                               {++last_number_},
                                               {},
                                               PayloadKind::data,
                                               payload});
  sender_.flush_now();
  return 0;
}

// Each host is sent a different challenge, so that it can prove only its own addresses.
std::size_t HandshakeSender::send_auth_request(const Peer& peer, const GenericMessage& message,
                                               LocatorList addresses) {
  std::size_t held_back = 0;
  while (!addresses.empty()) {
    const auto host = addresses.front();
    const auto here = std::ranges::stable_partition(addresses, [&](const auto& locator) {
      return locator.kind != host.kind || locator.address != host.address;
    });
    const LocatorList there(here.begin(), here.end());
    addresses.erase(here.begin(), here.end());
    if (sender_.amplification_limit().left(peer.prefix(), there) < kHeaders) {
      held_back = std::max(held_back, kHeaders);
      continue;
    }
    auto challenging = message;
    challenging.data.front().binary_properties.push_back(
        {std::string(PeerHandshake::kChallenge),
         sender_.amplification_limit().challenge(peer.prefix(), host)});
    held_back = std::max(held_back, send(peer, challenging, there));
  }
  return held_back;
}

// Cyclone DDS answers queries of builtin readers before it has authenticated their participant. The
// answers are a few octets longer than the queries, and allow sending three times their own length.
// A count of 0 leaves no trace in its writers.
void HandshakeSender::add_credit(Peer& peer, const LocatorList& addresses) {
  static constexpr std::pair<EntityId, EntityId> kPairs[] = {
      {kPublicationsReader, kPublicationsWriter},
      {kSubscriptionsReader, kSubscriptionsWriter},
      {kParticipantMessageReader, kParticipantMessageWriter}};
  constexpr std::size_t kQuestions = 84, kAnswers = 90, kGain = 3 * kAnswers - kQuestions;
  constexpr std::size_t kMaxRounds = 64;
  if (peer.data.vendor != kVendorCyclone) return;
  const auto left = sender_.amplification_limit().left(peer.prefix(), addresses);
  if (left <= kHeaders || left + peer.expected_answer_octets >= peer.deferred_octets) return;
  const auto needed = (peer.deferred_octets - left - peer.expected_answer_octets) / kGain + 1;
  const auto rounds = std::min({needed, (left - kHeaders) / kQuestions, kMaxRounds});
  for (std::size_t round = 0; round < rounds; ++round)
    for (const auto& [reader, writer] : kPairs)
      sender_.add_unauthenticated(
          {peer.prefix(), addresses},
          AckNack{reader, writer, SequenceNumberSet(SequenceNumber{1}), 0, false});
  sender_.flush_now();
  peer.expected_answer_octets += rounds * AmplificationLimit::kFactor * kAnswers;
}

}  // namespace ddssec::rtps
