#include "rtps/participant/builtin_matcher.hpp"

namespace ddssec::rtps {

BuiltinMatcher::BuiltinMatcher(ParticipantCore& core, BuiltinEndpoints& builtin)
    : core_(core), builtin_(builtin) {}

void BuiltinMatcher::match(RemoteParticipant& remote) {
  builtin_.each([&](const auto& info, auto&, auto&) {
    match(info, remote, true);
    match(info, remote, false);
  });
}

void BuiltinMatcher::match(const EntityId& local, RemoteParticipant& remote) {
  for (const auto& info : kBuiltinTopics)
    if (info.writer == local || info.reader == local) match(info, remote, info.writer == local);
}

void BuiltinMatcher::match(const BuiltinTopicInfo& info, RemoteParticipant& remote,
                           bool with_writer) {
  if (info.topic == BuiltinTopic::participants_secure && remote.data.vendor == kVendorFastDds &&
      !remote.heard_participants_secure)
    return;
  // The reader of a pair is the bit above its writer.
  const auto mask = with_writer ? 0xaaaaaaaau : 0x55555555u;
  if ((remote.data.builtin_endpoints & info.bits & mask) == 0) return;
  const EntityId own = with_writer ? info.writer : info.reader;
  const Guid other{remote.prefix(), with_writer ? info.reader : info.writer};
  if (core_.security && !core_.security->introduce(own, other)) return;
  if (with_writer)
    builtin_.writer(info.topic).match({other, true, true, remote.metatraffic}, core_.now);
  else
    builtin_.find_reader(own)->match({other, true, remote.metatraffic}, core_.now);
}

void BuiltinMatcher::unmatch(const RemoteParticipant& remote) {
  const auto prefix = remote.prefix();
  builtin_.each([&](const auto& info, auto& writer, auto& reader) {
    writer.unmatch({prefix, info.reader});
    reader.unmatch({prefix, info.writer});
  });
}

// Fast DDS announces DCPSParticipantsSecure. Up to 2.9 it does not have it; later it has, and takes
// part in nothing else until it has our data from there. So it is matched once it is heard there.
void BuiltinMatcher::note_participants_secure(RemoteParticipant& remote) {
  if (std::exchange(remote.heard_participants_secure, true)) return;
  if (remote.accepted && remote.data.vendor == kVendorFastDds) {
    match(kParticipantsSecureWriter, remote);
    match(kParticipantsSecureReader, remote);
  }
}

}  // namespace ddssec::rtps
