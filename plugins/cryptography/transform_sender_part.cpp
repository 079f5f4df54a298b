// The part of a protected message that its sender may send (sender_part.hpp), for a host that
// does not check sources.
#include <algorithm>

#include "plugins/cryptography/message.hpp"
#include "plugins/cryptography/sender_part.hpp"
#include "plugins/cryptography/transform.hpp"

namespace ddssec::cryptography {
namespace {

// The announcements of the sender of a message, and of other participants in its process.
class DiscoveryInMessage final : public DiscoveryOfPeers {
 public:
  DiscoveryInMessage(const CryptographyState& state, spi::ParticipantCryptoHandle receiver,
                     spi::ParticipantCryptoHandle sender, const GuidPrefix& prefix)
      : state_(state), receiver_(receiver), sender_(sender), prefix_(prefix) {}

  PeerDiscovery* of(const GuidPrefix& owner) override {
    if (owner == prefix_) {
      const auto remote = state_.remote_participant(sender_);
      return remote ? &(*remote)->discovery : nullptr;
    }
    const auto local = state_.local_participant(receiver_);
    if (!local) return nullptr;
    const auto peer = find_peer(state_, **local, owner);
    return peer && *peer != nullptr ? &(*peer)->discovery : nullptr;
  }
  MonotonicTime now() const override { return state_.services.clock.monotonic(); }
  bool is_closed(const EntityId& writer) const override {
    const auto local = state_.local_participant(receiver_);
    return local && (*local)->closed_discovery.includes(writer);
  }

 private:
  const CryptographyState& state_;
  const spi::ParticipantCryptoHandle receiver_, sender_;
  const GuidPrefix& prefix_;
};

// Turns a submessage into padding, so that the host continues after it. A submessage of length 0
// goes to the end, but as padding it would be empty. So the sender's part ends before it.
void hide_submessage(MutableBytes content, std::size_t at, SenderPart& part) {
  constexpr std::uint8_t kPad = 0x01;
  if (read_submessage_header(content.subspan(at)).length == 0)
    part.size = std::min(part.size, at);
  else
    content[at] = kPad;
}

}  // namespace

// Cyclone DDS sends submessages of several participants of one process in one message, under the
// key of one of them. So a message in another peer's name can be honest. It is reported once for
// each peer, with its own code (info_source_of_peer), which claims no more than that. A message in
// the name of an unknown participant, or of the local one, cannot be honest.
void Transform::report_end(spi::ParticipantCryptoHandle receiver,
                           spi::ParticipantCryptoHandle sender, const SenderPart& part,
                           const GuidPrefix& prefix) const {
  const ReadGuard guard;
  const auto local = state_.local_participant(receiver);
  const auto remote = state_.remote_participant(sender);
  auto* const pair = remote ? (*remote)->pair(receiver.value) : nullptr;
  if (!part.named || !local || pair == nullptr) return state_.report(*part.ended, prefix);
  const auto peer = find_peer(state_, **local, *part.named);
  if (!peer) return;  // it is reported next time
  if (*peer == nullptr) return state_.report(*part.ended, prefix);
  if (pair->names_spoken.note(*part.named))
    state_.report(Error(Code::info_source_of_peer, part.ended->details()), prefix);
}

// Drops what an insider sends in another participant's name, but not what it sends in its own. An
// honest process whose participants have different certificates keeps working, because lost
// submessages are sent again.
std::size_t Transform::keep_part_of_sender(spi::ParticipantCryptoHandle receiver,
                                           spi::ParticipantCryptoHandle sender,
                                           MutableBytes message) {
  const auto content = message.subspan(kRtpsHeaderSize);
  const auto prefix = GuidPrefix::from(message.subspan(8, GuidPrefix::size));
  const ReadGuard guard;
  DiscoveryInMessage peers(state_, receiver, sender, prefix);
  auto part = part_of_sender(content, prefix, peers);
  for (const auto at : part.hidden) hide_submessage(content, at, part);
  const auto local = state_.local_participant(receiver);
  if (!local || !(*local)->trusts_type_information) {
    for (const auto& place : part.types) hide_type_information(content, place);
    for (const auto at : part.lookups) hide_submessage(content, at, part);
  }
  if (part.size < content.size()) [[unlikely]]
    wipe(content.subspan(part.size));
  if (part.ended) [[unlikely]]
    report_end(receiver, sender, part, prefix);
  return kRtpsHeaderSize + part.size;
}

}  // namespace ddssec::cryptography
