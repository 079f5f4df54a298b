#include "rtps/participant/shared_memory.hpp"

#include <algorithm>

#include "rtps/security/memory_exchange.hpp"

namespace ddssec::rtps {
namespace {

bool is_known(const ParticipantCore& core, const RemoteParticipant& remote) {
  return remote.data.vendor == kVendorDdssec && core.is_authenticated(remote.prefix());
}

bool is_here(const ParticipantCore& core, const LocatorList& locators) {
  const auto here = core.host_of(Locator::udp_v4({127, 0, 0, 1}, 0));
  return !locators.empty() && std::ranges::all_of(locators, [&](const Locator& locator) {
    return core.host_of(locator) == here;
  });
}

}  // namespace

MemoryExchange* memory_of(const ParticipantCore& core) {
  return core.security ? core.security->memory() : nullptr;
}

void start_memory(const ParticipantCore& core) {
  if (auto* const memory = memory_of(core)) memory->start();
}

std::optional<int> memory_descriptor(const ParticipantCore& core) {
  const auto* const memory = memory_of(core);
  return memory == nullptr ? std::nullopt : std::optional(memory->descriptor());
}

void serve_memory(const ParticipantCore& core, MonotonicTime now) {
  if (auto* const memory = memory_of(core)) memory->serve(now);
}

void note_reader(ParticipantCore& core, LocalWriter& writer, const RemoteParticipant& remote,
                 const Guid& reader, const LocatorList& locators) {
  auto* const memory = memory_of(core);
  if (memory == nullptr || !is_known(core, remote) || !is_here(core, locators)) return;
  const auto kind = core.security->keyring().kind_of(writer.data.guid.entity, reader);
  if (kind == Keyring::PairKind::ordinary) memory->add_reader(*writer.protocol, reader);
}

void note_reader_gone(ParticipantCore& core, const EntityId& writer, const Guid& reader) {
  if (auto* const memory = memory_of(core)) memory->remove_reader(writer, reader);
}

void note_own_writer_gone(ParticipantCore& core, const EntityId& writer) {
  if (auto* const memory = memory_of(core)) memory->remove_writer(writer);
}

void note_writer(ParticipantCore& core, const EntityId& reader, const RemoteParticipant& remote,
                 const Guid& writer, const LocatorList& locators) {
  auto* const memory = memory_of(core);
  if (memory != nullptr && is_known(core, remote))
    memory->mapped().add_reader(writer, reader, is_here(core, locators));
}

void note_writer_gone(ParticipantCore& core, const EntityId& reader, const Guid& writer) {
  if (auto* const memory = memory_of(core)) memory->mapped().remove_reader(writer, reader);
}

}  // namespace ddssec::rtps
