#include "rtps/participant/builtin_matcher.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

bool is_sedp(const BuiltinTopicInfo& info, bool secure) {
  return secure ? info.topic == BuiltinTopic::publications_secure ||
                      info.topic == BuiltinTopic::subscriptions_secure
                : info.topic == BuiltinTopic::publications ||
                      info.topic == BuiltinTopic::subscriptions;
}

}  // namespace

BuiltinMatcher::BuiltinMatcher(ParticipantCore& core, BuiltinEndpoints& builtin)
    : core_(core), builtin_(builtin) {}

void BuiltinMatcher::match(RemoteParticipant& remote, bool returns) {
  builtin_.each([&](const auto& info, auto&, auto&) {
    match(info, remote, true);
    match(info, remote, false,
          returns && !proven_keys(info.reader, {remote.prefix(), info.writer}));
  });
}

void BuiltinMatcher::match(const EntityId& local, RemoteParticipant& remote) {
  for (const auto& info : kBuiltinTopics)
    if (info.writer == local || info.reader == local) match(info, remote, info.writer == local);
}

void BuiltinMatcher::match(const BuiltinTopicInfo& info, RemoteParticipant& remote,
                           bool with_writer, bool again, const std::optional<Sha256Digest>& keys) {
  if (info.topic == BuiltinTopic::participants_secure && remote.data.vendor == kVendorFastDds &&
      !remote.heard_participants_secure)
    return;
  // In each pair of bits, the reader's bit is the one above the writer's.
  const auto mask = with_writer ? 0xaaaaaaaau : 0x55555555u;
  if ((remote.data.builtin_endpoints & info.bits & mask) == 0) return;
  const EntityId own = with_writer ? info.writer : info.reader;
  const Guid other{remote.prefix(), with_writer ? info.reader : info.writer};
  if (core_.security && !core_.security->register_pair(own, other)) return;
  if (with_writer)
    builtin_.writer(info.topic).match({other, true, true, remote.metatraffic}, core_.now);
  else
    builtin_.find_reader(own)->match(
        {.guid = other,
         .is_reliable = true,
         .locators = remote.metatraffic,
         .keys = keys ? keys : proven_keys(own, other),
         .begins_at_zero = again && remote.data.vendor == kVendorFastDds,
         .contradicted = core_.security && is_sedp(info, false) ? contradicted_ : nullptr},
        core_.now, keys.has_value());
}

void BuiltinMatcher::unmatch(const RemoteParticipant& remote, bool may_return) {
  const auto prefix = remote.prefix();
  builtin_.each([&](const auto& info, auto& writer, auto& reader) {
    writer.unmatch({prefix, info.reader});
    const Guid other{prefix, info.writer};
    reader.unmatch(other, may_return ? proven_keys(info.reader, other) : std::nullopt);
  });
}

// Returns the keys that protect everything that the writer sends; empty if anyone can send in its
// name.
std::optional<Sha256Digest> BuiltinMatcher::proven_keys(const EntityId& reader,
                                                        const Guid& writer) const {
  const bool is_proven =
      core_.security && core_.security->core().origin(reader, writer) == EventOrigin::its_keys;
  return is_proven ? core_.keys_of(reader, writer) : std::nullopt;
}

// The endpoints are unmatched first, because a new match begins with the first announcement that
// the writer keeps. With its keys, that is the first one that a HEARTBEAT names that is new.
void BuiltinMatcher::read_again(const BuiltinTopicInfo& info, RemoteParticipant& remote,
                                bool drops_recorded) {
  const Guid writer{remote.prefix(), info.writer};
  const auto keys = drops_recorded ? core_.keys_of(info.reader, writer) : std::nullopt;
  builtin_.find_reader(info.reader)->unmatch(writer, keys);
  match(info, remote, false, true, keys);
}

void BuiltinMatcher::refresh_announcements(RemoteParticipant& remote, bool secure,
                                           bool drops_recorded) {
  for (const auto& info : kBuiltinTopics)
    if (is_sedp(info, secure)) read_again(info, remote, drops_recorded);
}

void BuiltinMatcher::refresh_participant(RemoteParticipant& remote, bool drops_recorded) {
  for (const auto& info : kBuiltinTopics)
    if (info.topic == BuiltinTopic::participants_secure) read_again(info, remote, drops_recorded);
}

void BuiltinMatcher::offer_again(const RemoteParticipant& remote) {
  for (const auto& info : kBuiltinTopics) {
    const Guid reader{remote.prefix(), info.reader};
    auto& writer = builtin_.writer(info.topic);
    if ((is_sedp(info, false) || is_sedp(info, true)) && writer.readers().contains(reader))
      writer.request_acknack(reader, remote.metatraffic);
  }
}

bool BuiltinMatcher::has_read(const RemoteParticipant& remote, bool secure) const {
  return std::ranges::all_of(kBuiltinTopics, [&](const auto& info) {
    if (!is_sedp(info, secure)) return true;
    const auto* writer = builtin_.find_reader(info.reader)->writer({remote.prefix(), info.writer});
    return writer == nullptr || (writer->was_heard() && writer->has_caught_up());
  });
}

void BuiltinMatcher::readdress(const RemoteParticipant& remote, MonotonicTime now) {
  builtin_.each([&](const auto& info, auto& writer, auto& reader) {
    writer.readdress({remote.prefix(), info.reader}, remote.metatraffic, now);
    reader.readdress({remote.prefix(), info.writer}, remote.metatraffic);
  });
}

// All versions of Fast DDS announce DCPSParticipantsSecure, but up to 2.9 Fast DDS does not
// implement it. Later versions do, and take part in nothing else until they have received the
// peer's data on it. So it is matched when the first message from it arrives.
void BuiltinMatcher::note_participants_secure(RemoteParticipant& remote) {
  if (std::exchange(remote.heard_participants_secure, true)) return;
  if (remote.accepted && remote.data.vendor == kVendorFastDds) {
    match(kParticipantsSecureWriter, remote);
    match(kParticipantsSecureReader, remote);
  }
}

}  // namespace ddssec::rtps
