#include "rtps/participant/endpoint_directory.hpp"

namespace ddssec::rtps {

std::span<StatefulReader* const> EndpointDirectory::readers_of(const Guid& writer) {
  if (writer.entity == kVolatileMessageWriter) {
    volatile_reader_ =
        core_.security ? core_.security->exchange().volatile_reader(writer.prefix) : nullptr;
    return {&volatile_reader_, volatile_reader_ == nullptr ? 0u : 1u};
  }
  if (is_builtin(writer.entity)) return local_.builtin().readers_of(writer.entity);
  auto* remote = remotes_.find_endpoint(writer);
  if (remote == nullptr) return {};
  return remote->readers;
}

StatefulWriter* EndpointDirectory::writer_for(const EntityId& writer, const GuidPrefix& reader) {
  if (writer == kVolatileMessageWriter)
    return core_.security ? core_.security->exchange().volatile_writer(reader) : nullptr;
  if (is_builtin(writer)) return local_.builtin().find_writer(writer);
  auto* local = local_.find_writer(writer);
  return local == nullptr ? nullptr : local->protocol.get();
}

bool EndpointDirectory::sends_keys(const GuidPrefix& participant) {
  const auto* remote = remotes_.find(participant);
  return remote != nullptr && remote->data.vendor == kVendorDdssec;
}

bool EndpointDirectory::marks_ends(const GuidPrefix& participant) {
  const auto* remote = remotes_.find(participant);
  return remote != nullptr && remote->marks_ends;
}

}  // namespace ddssec::rtps
