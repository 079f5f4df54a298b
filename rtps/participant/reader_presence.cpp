#include "rtps/participant/reader_presence.hpp"

#include "rtps/participant/remote_addresses.hpp"
#include "rtps/participant/shared_memory.hpp"

namespace ddssec::rtps {

bool ReaderPresence::awaits(LocalWriter& writer, const EndpointData& reader) {
  if (!shows_readiness(writer, reader)) return false;
  writer.unready.insert(reader.guid);
  readiness_.add(writer.data.guid, reader.guid, core_.now);
  return true;
}

// The reader shows that it is ready by its first ACKNACK. With a durable writer, a late joiner
// misses nothing, so there is no need to wait.
bool ReaderPresence::shows_readiness(const LocalWriter& writer, const EndpointData& reader) const {
  if (!core_.security) return false;
  const auto* attributes = core_.security->keyring().attributes(writer.data.guid.entity);
  const bool needs_keys = core_.attributes().is_rtps_protected() ||
                          (attributes != nullptr && (attributes->is_submessage_protected() ||
                                                     attributes->is_payload_protected()));
  return needs_keys && reader.guid.prefix != local_.prefix() &&
         core_.is_authenticated(reader.guid.prefix) && reader.qos.is_reliable() &&
         writer.data.qos.is_reliable() &&
         std::min(writer.data.qos.durability, reader.qos.durability) == DurabilityKind::volatile_;
}

void ReaderPresence::forget(LocalWriter& writer, const Guid& reader) {
  writer.silent.erase(reader);
  if (writer.unready.erase(reader) > 0) readiness_.remove(writer.data.guid, reader);
}

void ReaderPresence::note_unproven_end(LocalWriter& writer, const Guid& reader) {
  end_checks_.add({writer.data.guid, reader}, core_.now);
}

void ReaderPresence::note_heard(LocalWriter& writer, const GuidPrefix& source,
                                const AckNack& acknack, bool is_protected) {
  const Guid reader{source, acknack.reader};
  const auto silent = writer.silent.find(reader);
  if (silent == writer.silent.end()) return note_ready(writer, reader);
  // The age of the key does not matter, because the counts are forgotten now.
  if (!silent->second.accept(acknack, is_protected, KeyAge::newest)) return;  // a repetition
  writer.silent.erase(silent);
  match_again_(writer.data.guid.entity, reader);
}

void ReaderPresence::note_ready(LocalWriter& writer, const Guid& reader) {
  if (writer.unready.erase(reader) == 0) return;
  readiness_.remove(writer.data.guid, reader);
  if (const auto* data = remotes_.endpoint(reader)) writer.listener->on_matched(*data);
}

void ReaderPresence::tick() {
  while (const auto due = readiness_.take_due(core_.now))
    if (auto* writer = local_.find_writer(due->writer.entity)) note_ready(*writer, due->reader);
  end_checks_.tick(core_.now);
}

// ---- doubt

std::optional<std::uint64_t> ReaderPresence::answers(const ReaderEndChecks::ReaderPair& pair) {
  const auto* writer = local_.find_writer(pair.writer.entity);
  if (writer == nullptr) return std::nullopt;
  const auto silent = writer->silent.find(pair.reader);
  if (silent != writer->silent.end()) return silent->second.taken();
  const auto* proxy = writer->protocol->readers().find(pair.reader);
  if (proxy == nullptr || !proxy->acknowledges()) return std::nullopt;
  return proxy->acknacks.taken();
}

void ReaderPresence::request_sign_of_life(const ReaderEndChecks::ReaderPair& pair) {
  auto* writer = local_.find_writer(pair.writer.entity);
  auto* remote = remotes_.find(pair.reader.prefix);
  const auto* data = remotes_.endpoint(pair.reader);
  if (writer == nullptr || remote == nullptr || data == nullptr) return;
  writer->protocol->request_acknack(pair.reader, addresses_of(core_, *remote, *data));
}

// The keys of the reader are kept, so that its answer can be read.
void ReaderPresence::on_no_answer(const ReaderEndChecks::ReaderPair& pair) {
  auto* writer = local_.find_writer(pair.writer.entity);
  const auto* data = remotes_.endpoint(pair.reader);
  if (writer == nullptr || data == nullptr) return;
  const auto* proxy = writer->protocol->readers().find(pair.reader);
  if (proxy == nullptr || !writer->matched.remove(pair.reader)) return;
  forget(*writer, pair.reader);
  writer->silent.emplace(pair.reader, proxy->acknacks);
  if (core_.security)
    if (const auto displaced = core_.security->keyring().unregister_pair(
            pair.writer.entity, pair.reader, AfterMatch::silent);
        displaced &&
        core_.security->keyring().attributes(pair.writer.entity)->is_submessage_protected())
      writer->silent.erase(*displaced);  // without keys, its answer cannot be read
  writer->protocol->unmatch(pair.reader);
  note_reader_gone(core_, pair.writer.entity, pair.reader);
  writer->listener->on_unmatched(pair.reader);
  places_.note_room(MatchPlaces::Local(*writer));
  core_.raise_about(Error(Code::rtps_reader_silent, {.field = data->topic_name}), *data);
}

}  // namespace ddssec::rtps
