#include "tests/sim/claims.hpp"

#include "rtps/discovery/endpoint_data.hpp"
#include "tests/sim/mangle.hpp"
#include "wire/data.hpp"
#include "wire/entity_ids.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::rtps::sim {
namespace {

bool announces_writers(const EntityId& writer) {
  return writer == kPublicationsWriter || writer == kPublicationsSecureWriter;
}

bool announces_readers(const EntityId& writer) {
  return writer == kSubscriptionsWriter || writer == kSubscriptionsSecureWriter;
}

// Returns the endpoint that a payload of this writer announces.
std::optional<Guid> announced_by(const EntityId& writer, BytesView payload) {
  if (!announces_writers(writer) && !announces_readers(writer)) return std::nullopt;
  const auto data =
      announces_writers(writer) ? read_publication_data(payload) : read_subscription_data(payload);
  return data ? std::optional(data->guid) : std::nullopt;
}

}  // namespace

void claim(Bytes& submessages, const std::function<Guid(bool)>& other) {
  const auto original = submessages;
  auto reader = MessageReader::over_submessages({}, original);
  for (auto view = reader.next(); view && *view; view = reader.next()) {
    if ((*view)->id != SubmessageId::data) continue;
    const auto data = read_data(**view);
    if (!data || data->kind != PayloadKind::data) continue;
    const auto own = announced_by(data->writer, data->payload);
    if (!own) continue;
    const auto victim = other(announces_writers(data->writer));
    auto payload = to_bytes(data->payload);
    exchange(payload, own->octets(), victim.octets());
    exchange(payload, own->prefix.view(), victim.prefix.view());  // in PARTICIPANT_GUID
    std::ranges::copy(payload, submessages.begin() + (data->payload.data() - original.data()));
  }
}

}  // namespace ddssec::rtps::sim
