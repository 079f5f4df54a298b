#include "rtps/participant/rtps_participant.hpp"

#include <algorithm>

#include "rtps/participant/partition_change.hpp"
#include "rtps/participant/protection_change.hpp"
#include "rtps/participant/shared_memory.hpp"
#include "rtps/security/memory_exchange.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

// The largest size of c.pdata; the plugin refuses more.
constexpr std::size_t kMaxOwnData = 16384;

// Returns false if the source or the local addresses are not known.
bool is_from_elsewhere(const Locator& source, std::span<const NetworkInterface> own) {
  if (source.kind == LocatorKind::invalid || own.empty() || source.is_loopback()) return false;
  return std::ranges::none_of(own, [&](const auto& interface) {
    return interface.address.kind == source.kind && interface.address.address == source.address;
  });
}

// Sets the data that the participant signs about itself in handshakes.
Status describe_own(ParticipantCore& core, const Announcer& announcer) {
  Bytes octets(kMaxOwnData);
  SpanWriter out(octets, Endian::big);
  auto own = announcer.own_data();
  own.properties = {{std::string(kMarksEndsProperty), "1", true}};
  write_parameter_list(out, own);
  if (out.overflowed()) return fail(Code::length_out_of_range, {.document = "participant data"});
  octets.resize(out.size());
  core.security->core().set_own_data(std::move(octets));
  return {};
}

// Returns false if none of the former addresses is left.
bool adopt_addresses(ParticipantCore& core, OwnChange::Addresses addresses) {
  auto& config = core.config;
  const bool any_stays = std::ranges::any_of(config.metatraffic_unicast, [&](const auto& former) {
    return std::ranges::find(addresses.metatraffic, former) != addresses.metatraffic.end();
  });
  config.interfaces = std::move(addresses.interfaces);
  config.metatraffic_unicast = std::move(addresses.metatraffic);
  config.default_unicast = std::move(addresses.user);
  core.own_addresses = addresses_of_this_machine();
  return any_stays;
}

}  // namespace

// The function always returns true, because a change for a builtin reader is never refused for now.
RtpsParticipant::RtpsParticipant(ParticipantConfig config, Transport& transport, EventSink& events)
    : core_(std::move(config), transport, events),
      local_(core_, [this](BuiltinTopic topic, Change& change) {
        discovery_.on_builtin(topic, change);
        return true;
      }) {}

Status RtpsParticipant::enable_security(std::unique_ptr<OwnSecurity> own) {
  core_.security = std::make_unique<Security>(std::move(own), core_.sender, core_.timers,
                                              discovery_, core_.events);
  const auto announce = [this] {
    announce_protection(core_, local_, remotes_, matcher_);
    forget_refused(core_, remotes_);
    // It can only be too long when the participant is created.
    static_cast<void>(describe_own(core_, announcer_));
    announcer_.announce_again();
  };
  core_.security->admission().announce_with({announce,
                                             [this] { return are_moves_received(core_, local_); },
                                             [this] { local_.end_moves(); }});
  local_.builtin().add_secure_endpoints();
  receiver_.open_with(core_.security->keyring());
  DDSSEC_RETURN_IF_ERROR(describe_own(core_, announcer_));
  DDSSEC_RETURN_IF_ERROR(core_.security->start());
  announcer_.announce_securely();
  if (auto* const memory = memory_of(core_)) receiver_.fetch_from(&memory->mapped());
  return {};
}

ProtectionCounters RtpsParticipant::protection_counters() const {
  return core_.security ? core_.security->keyring().counters() : ProtectionCounters{};
}

AuthenticationCounters RtpsParticipant::authentication_counters() const {
  return core_.security ? core_.security->core().counters() : AuthenticationCounters{};
}

Status RtpsParticipant::revise_keys() {
  return core_.security ? core_.security->revise_keys() : fail(Code::rtps_key_revision_disabled);
}

void RtpsParticipant::receive(BytesView datagram, MonotonicTime now, const Locator& source) {
  const auto call = calls_.enter();
  core_.now = now;
  core_.source = SourceAddress(source);
  core_.source_host = core_.host_of(source);
  core_.sender.amplification_limit().begin_datagram(core_.source, datagram.size());
  core_.is_from_elsewhere = is_from_elsewhere(source, core_.config.interfaces);
  const auto gathering = gather();
  receiver_.receive(datagram, now);
  // In Cyclone DDS the peer waits for our next announcement before it begins another session.
  if (core_.security && core_.security->own().session_ends().take_proven())
    announcer_.announce_soon();
  discovery_.remove_gone();
}

void RtpsParticipant::tick(MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  core_.source_host = {};
  if (now >= core_.sender.flush_by()) core_.sender.flush();
  const auto gathering = gather();
  if (std::exchange(reads_first_, false)) return;
  announcer_.tick();
  liveliness_.tick();
  matcher_.presence().tick();
  if (core_.security) core_.security->tick(now);
  core_.timers.run(now);
  discovery_.tick();
}

MonotonicTime RtpsParticipant::next_tick() const {
  const auto next =
      std::min({announcer_.next_tick(), liveliness_.next_tick(), matcher_.presence().next_tick(),
                remotes_.next_end(), core_.sender.flush_by(), core_.timers.next()});
  return core_.security ? std::min(next, core_.security->next_tick()) : next;
}

Result<Guid> RtpsParticipant::create_writer(EndpointDescription request, EndpointListener& listener,
                                            MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  const auto gathering = gather();
  DDSSEC_ASSIGN_OR_RETURN(const auto created_writer,
                          local_.create_writer(std::move(request), listener));
  auto& writer = *created_writer;
  liveliness_.expect(writer.data.qos.liveliness);
  local_.publish(writer.data);
  matcher_.add(writer);
  return writer.data.guid;
}

Result<Guid> RtpsParticipant::create_reader(EndpointDescription request, EndpointListener& listener,
                                            MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  const auto gathering = gather();
  DDSSEC_ASSIGN_OR_RETURN(const auto created_reader,
                          local_.create_reader(std::move(request), listener));
  auto& reader = *created_reader;
  reader.protocol->on_alive([this](const Guid& writer) { liveliness_.note_alive(writer); });
  local_.publish(reader.data);
  matcher_.add(reader);
  return reader.data.guid;
}

void RtpsParticipant::remove(const Guid& endpoint, MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  if (auto* reader = local_.find_reader(endpoint.entity)) matcher_.remove(*reader);
  if (auto* writer = local_.find_writer(endpoint.entity)) matcher_.remove(*writer);
  local_.remove(endpoint);
}

Status RtpsParticipant::change_qos(const Guid& endpoint, Qos qos, MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos));
  const auto* writer = local_.find_writer(endpoint.entity);
  DDSSEC_RETURN_IF_ERROR(check_partition_change(core_, local_, endpoint.entity, qos));
  if (leaves_readers(core_, writer, qos)) DDSSEC_RETURN_IF_ERROR(core_.security->revise_keys());
  if (core_.security) core_.security->admission().set_partitions(endpoint.entity, qos.partition);
  const auto apply = [&](auto* local) {
    if (local == nullptr) return;
    local->data.qos = qos;
    if constexpr (requires { local->protocol->set_urgency(qos); })
      local->protocol->set_urgency(qos);
    local_.publish(local->data);
    matcher_.match_all(*local);
  };
  apply(local_.find_writer(endpoint.entity));
  apply(local_.find_reader(endpoint.entity));
  return {};
}

void RtpsParticipant::change_filter(const Guid& reader, ContentFilterProperty filter,
                                    MonotonicTime now) {
  core_.now = now;
  auto* local = local_.find_reader(reader.entity);
  if (local == nullptr) return;
  local->data.content_filter = std::move(filter);
  local_.publish(local->data);
}

void RtpsParticipant::change_own(OwnChange change, MonotonicTime now) {
  const auto call = calls_.enter();
  core_.now = now;
  core_.source_host = {};
  const auto gathering = gather();
  if (change.user_data) core_.config.user_data = std::move(*change.user_data);
  if (change.addresses) {
    const bool any_stays = adopt_addresses(core_, std::move(*change.addresses));
    const bool is_new = !any_stays && !core_.security;
    if (is_new) announcer_.leave(remotes_);
    discovery_.on_addresses_changed(is_new ? Discovery::ChangedAddresses::all
                                           : Discovery::ChangedAddresses::some);
    announcer_.announce_often();
  }
  // This cannot fail here: the data can be too long only when the participant is created.
  if (core_.security) static_cast<void>(describe_own(core_, announcer_));
  announcer_.announce_again();
}

void RtpsParticipant::assert_liveliness(LivelinessKind kind, MonotonicTime now) {
  core_.now = now;
  liveliness_.assert_liveliness(kind);
}

void RtpsParticipant::set_discovery_listener(DiscoveryListener* listener) {
  const auto call = calls_.enter();
  remotes_.set_discovery_listener(listener);
}

void RtpsParticipant::ignore_participant(const GuidPrefix& prefix) {
  if (!core_.ignored.add_participant(prefix)) return;
  calls_.after_call([this, prefix] {
    if (core_.security) core_.security->distrust(prefix);
    if (prefix == core_.config.prefix)
      matcher_.match_own();
    else
      discovery_.remove(prefix);
  });
}

void RtpsParticipant::ignore_endpoint(const Guid& guid) {
  if (!core_.ignored.add_endpoint(guid)) return;
  calls_.after_call([this, guid] {
    if (auto* remote = remotes_.find(guid.prefix)) matcher_.remove(*remote, guid.entity);
    if (guid.prefix != prefix()) return;
    if (auto* writer = local_.find_writer(guid.entity)) matcher_.match_all(*writer);
    if (auto* reader = local_.find_reader(guid.entity)) matcher_.match_all(*reader);
  });
}

void RtpsParticipant::ignore_topic(const std::string& name) {
  if (core_.ignored.add_topic(name))
    calls_.after_call([this, name] { matcher_.remove_topic(name); });
}

}  // namespace ddssec::rtps
