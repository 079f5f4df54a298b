#include "plugins/cyclonedds/own_announcements.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "wire/data.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/parameter_list.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::cyclonedds {
namespace {

// Returns the serialized payload; nothing if this must not be announced.
std::optional<Bytes> payload_of(const GuidPrefix& own, BytesView participant_data) {
  const auto guid = Guid{own, kEntityIdParticipant}.octets();
  rtps::ParameterReader list(participant_data, Endian::big);
  bool has_guid = false, has_token = false, has_sentinel = false;
  while (!list.at_end()) {
    const auto parameter = list.next();
    if (!parameter) return std::nullopt;
    has_sentinel = !*parameter;
    if (has_sentinel) break;
    if ((*parameter)->id == pid::kIdentityToken) has_token = true;
    if ((*parameter)->id == pid::kParticipantGuid)
      has_guid = std::ranges::equal((*parameter)->value, guid);
  }
  if (!has_guid || !has_token) return std::nullopt;
  Bytes out{0, 2, 0, 0};  // PL_CDR, big-endian
  const auto read = participant_data.first(list.consumed());
  out.insert(out.end(), read.begin(), read.end());
  constexpr std::array<std::uint8_t, 4> kSentinel{0, 1, 0, 0};
  if (!has_sentinel) out.insert(out.end(), kSentinel.begin(), kSentinel.end());
  return out;
}

}  // namespace

std::optional<Bytes> write_announcement(const GuidPrefix& own, BytesView participant_data) {
  constexpr std::size_t kRest = 128;
  const auto payload = payload_of(own, participant_data);
  if (!payload) return std::nullopt;
  Bytes octets(payload->size() + kRest);
  rtps::SpanWriter out(octets);
  write(out, rtps::Header{.vendor = rtps::kVendorCyclone, .prefix = own});
  // The host's own announcements have this number or a later one, so they are not taken for old
  // ones. Without INFO_DST, the peer's host answers.
  rtps::write(out, rtps::Data{.reader = {},
                              .writer = rtps::kSpdpWriter,
                              .sequence_number = rtps::SequenceNumber{1},
                              .kind = rtps::PayloadKind::data,
                              .payload = *payload});
  if (out.overflowed()) return std::nullopt;
  octets.resize(out.size());
  return octets;
}

void OwnAnnouncements::note_data(spi::IdentityHandle local, const GuidPrefix& prefix,
                                 BytesView participant_data) {
  if (participant_data.size() > kMaxOctets) return;
  auto message = write_announcement(prefix, participant_data);
  const std::lock_guard lock(mutex_);
  if (message) messages_.insert_or_assign(local, *std::move(message));
}

void OwnAnnouncements::remove_local(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  messages_.erase(local);
  std::erase_if(waiting_, [&](const auto& entry) { return entry.first.first == local; });
}

void OwnAnnouncements::note_reset(spi::IdentityHandle local, const Guid& peer,
                                  const std::vector<spi::UdpAddress>& to, Duration now) {
  const std::lock_guard lock(mutex_);
  if (!messages_.contains(local) || waiting_.size() >= kMaxWaiting) return;
  waiting_.try_emplace({local, peer}, Waiting{now + kAfterReset, to});
}

std::vector<OwnAnnouncements::Announcement> OwnAnnouncements::take_due(Duration now) {
  const std::lock_guard lock(mutex_);
  std::vector<Announcement> out;
  for (const auto& [pair, waiting] : waiting_)
    if (waiting.at <= now)
      out.push_back({pair.first, pair.second, messages_.at(pair.first), waiting.to});
  std::erase_if(waiting_, [&](const auto& entry) { return entry.second.at <= now; });
  return out;
}

}  // namespace ddssec::cyclonedds
