#include "plugins/cryptography/cryptography_state.hpp"

#include <algorithm>
#include <utility>

#include "base/rollback.hpp"

namespace ddssec::cryptography {
namespace {

KeyServices key_services(const AeadBackend& aead, RetiredObjects& retired_objects, Random& random,
                         const CryptographyOptions& options) {
  constexpr auto kMax = std::uint64_t{1} << 32;
  return {aead, retired_objects, std::clamp(options.max_blocks_per_session, std::uint64_t{1}, kMax),
          std::clamp(options.max_sessions_per_key, std::uint64_t{1}, kMax), random};
}

}  // namespace

CryptographyState::CryptographyState(const PluginServices& given, const AeadBackend& aead,
                                     const CryptographyOptions& options,
                                     std::uint64_t first_generation)
    : services(given),
      header_prefix_is_network_order(options.header_prefix_is_network_order),
      host_checks_sources(options.host_checks_sources),
      keys(key_services(aead, retired_objects, services.random, options)),
      registry(first_generation) {}

SubjectId subject_of(std::int64_t identity, const ParticipantPair& pair) {
  if (!pair.peer_prefix) return std::uint64_t{1} << 63 | static_cast<std::uint64_t>(identity);
  std::uint64_t subject = 0;
  for (std::size_t i = 0; i < 6; ++i) subject = subject << 8 | pair.peer_prefix->octets[i];
  return subject;
}

Status CryptographyState::claim_place(RemoteEndpointCrypto& reader, const ParticipantPair& pair) {
  if (reader.kind() != EntityKind::remote_reader || !reader.receiver_key || reader.place_subject)
    return {};
  const auto subject = subject_of(reader.participant.identity, pair);
  if (auto status = reader.local.receivers.claim(subject); !status) {
    report(status.error(), pair.peer_prefix);
    return status;
  }
  reader.place_subject = subject;
  return {};
}

void CryptographyState::release_place(RemoteEndpointCrypto& reader) noexcept {
  if (const auto place = std::exchange(reader.place_subject, std::nullopt))
    reader.local.receivers.release(*place);
}

void CryptographyState::report(const Error& error, const std::optional<GuidPrefix>& prefix) const {
  const auto guid = prefix ? Guid{*prefix, kEntityIdParticipant}.to_string() : std::string();
  services.events.raise(Event(error, {}, guid, PeerProof::authenticated));
}

void CryptographyState::note_former(std::int64_t handle, const RemoteKeys& remote_keys) {
  if (!remote_keys.former.empty()) former_until[handle] = remote_keys.former.front().until;
}

void CryptographyState::publish_route(RemoteEndpointCrypto& endpoint) {
  Route route{.key_id = {},
              .receiver_key_id = {},
              .local_participant = endpoint.local.participant.handle(),
              .kind = endpoint.kind(),
              .handle = endpoint.handle(),
              .number = ++routes_made};
  if (!endpoint.local.is_volatile) {
    const auto& key = endpoint.remote_keys.read()->submessage->material();
    route.key_id = key.sender_key_id;
    route.receiver_key_id = key.receiver_key_id;
  }
  const auto former = endpoint.route.exchange(route.number);
  Rollback keep_former([&] { endpoint.route = former; });
  endpoint.participant.routes.add(route, retired_objects);
  keep_former.release();
  if (former != 0) endpoint.participant.routes.note_gone();
}

std::optional<const RemoteParticipantCrypto*> find_peer(const CryptographyState& state,
                                                        const LocalParticipantCrypto& local,
                                                        const GuidPrefix& prefix) {
  const std::unique_lock lock(state.mutex, std::try_to_lock);
  if (!lock.owns_lock()) return std::nullopt;
  for (const auto handle : local.matched) {
    const auto remote =
        state.registry.find<RemoteParticipantCrypto>(handle, EntityKind::remote_participant);
    if (!remote) continue;
    const auto pair = (*remote)->pairs.find(local.handle());
    if (pair != (*remote)->pairs.end() && pair->second->peer_prefix == prefix) return *remote;
  }
  return nullptr;
}

}  // namespace ddssec::cryptography
