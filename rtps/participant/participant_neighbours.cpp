// Participant, the part that joins endpoints of one process without the network.
#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {

// What is protected for the wire goes by the wire, where the other side proves who it is.
bool Participant::is_open(const EntityId& endpoint) const {
  if (!security_) return true;
  const auto* attributes = security_->keyring().attributes(endpoint);
  return attributes != nullptr && !attributes->is_submessage_protected() &&
         !attributes->is_payload_protected() && !security_->own().attributes().is_rtps_protected();
}

// The same answer for both sides of a pair.
Participant* Participant::neighbour(const EntityId& local, const Guid& remote) {
  if (remote.prefix == config_.prefix) return this;
  auto* other = config_.neighbourhood ? config_.neighbourhood->find(remote.prefix) : nullptr;
  const bool open = other != nullptr && !security_ == !other->security_ && is_open(local) &&
                    other->is_open(remote.entity);
  return open ? other : nullptr;
}

void Participant::join(const Guid& local, const Guid& remote) {
  auto* other = neighbour(local.entity, remote);
  if (other == nullptr) return;
  const auto& [writer_guid, reader_guid] =
      is_writer(local.entity) ? std::pair(local, remote) : std::pair(remote, local);
  auto& of_writer = is_writer(local.entity) ? *this : *other;
  auto& of_reader = is_writer(local.entity) ? *other : *this;
  auto* writer = of_writer.writer(writer_guid);
  auto* reader = of_reader.reader(reader_guid);
  if (writer != nullptr && reader != nullptr) writer->attach(*reader);
}

void Participant::meet(LocalWriter& writer, LocalReader& reader) {
  if (is_ignored(writer.data) || is_ignored(reader.data)) {
    forget(writer, reader.data.guid);
    forget(reader, writer.data.guid);
    return;
  }
  self_.endpoints[writer.data.guid.entity].data = writer.data;
  self_.endpoints[reader.data.guid.entity].data = reader.data;
  match(writer, self_, reader.data);
  match(reader, self_, writer.data);
}

template <class Local>
void Participant::part_from(const std::vector<Local*>& others, const Guid& endpoint) {
  for (auto* other : others) forget(*other, endpoint);
  std::erase_if(self_.watches, [&](const auto& w) { return w.writer == endpoint; });
  self_.endpoints.erase(endpoint.entity);
}
template void Participant::part_from(const std::vector<LocalWriter*>&, const Guid&);
template void Participant::part_from(const std::vector<LocalReader*>&, const Guid&);

}  // namespace ddssec::rtps
