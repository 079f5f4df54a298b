#include "rtps/dcps/domain_participant.hpp"

#include <fmt/format.h>

#include "rtps/dcps/no_callbacks.hpp"
#include "rtps/dcps/participant_parts.hpp"
#include "rtps/dcps/participant_service.hpp"

namespace ddssec::rtps {
namespace {

std::unexpected<Error> bad_option_error(std::string field, std::string expected,
                                        std::string found) {
  return fail(Code::invalid_property, {.document = "participant options",
                                       .field = std::move(field),
                                       .expected = std::move(expected),
                                       .found = std::move(found)});
}

Result<std::uint32_t> random_entity(Random& random) {
  std::array<std::uint8_t, 3> octets{};
  DDSSEC_RETURN_IF_ERROR(random.fill(octets));
  const auto number = std::uint32_t{octets[0]} << 16 | std::uint32_t{octets[1]} << 8 | octets[2];
  return 1 + number % ParticipantConfig::kMaxFirstEntity;
}

void raise_joined(const DomainParticipantOptions& options, const ParticipantSockets& sockets,
                  EventSink& events) {
  const std::string_view multicast = sockets.has_joined() ? "with multicast" : "without multicast";
  const bool alone = std::ranges::all_of(
      sockets.interfaces(), [](const auto& interface) { return interface.address.is_loopback(); });
  auto note =
      fmt::format("domain {} on {}, {}{}", options.domain_id, to_string(sockets.interfaces()),
                  multicast, alone ? "; no other machine is reached" : "");
  if (sockets.index() >= DomainParticipant::kAnnouncedIndexes)
    note += fmt::format(
        "; participant index {}: participants that name this machine in `peers` do not find it",
        sockets.index());
  events.raise(Event(Error(Code::rtps_joined, {.note = std::move(note)})));
}

Status announce_by_multicast(ParticipantSockets& sockets, ParticipantConfig& config,
                             EventSink& events) {
  const auto group =
      Locator::udp_v4({239, 255, 0, 1}, static_cast<std::uint16_t>(ports::base(config.domain_id)));
  std::vector<Error> errors;
  for (const auto& interface : sockets.interfaces())
    if (const auto joined = sockets.join(group, interface); !joined)
      errors.push_back(joined.error().with_default_document(to_string({&interface, 1})));
  // If there are peers to announce to, other participants can still be found.
  if (!errors.empty() && !sockets.has_joined() && config.announce_to.empty())
    return std::unexpected(errors.front());
  for (const auto& error : errors) events.raise(Event(error));
  if (!sockets.has_joined()) return {};
  config.metatraffic_multicast = {group};
  config.announce_to.push_back(group);
  return {};
}

Result<ParticipantConfig> config_of(const DomainParticipantOptions& options,
                                    const GuidPrefix& prefix, ParticipantSockets& sockets,
                                    const PluginServices& services) {
  ParticipantConfig config{.prefix = prefix,
                           .domain_id = options.domain_id,
                           .domain_tag = options.domain_tag,
                           .entity_name = options.entity_name,
                           .user_data = options.user_data,
                           .lease_duration = options.lease_duration,
                           .metatraffic_unicast = sockets.metatraffic(),
                           .default_unicast = sockets.user(),
                           .interfaces = sockets.interfaces()};
  config.announcement_period = options.announcement_period;
  config.fragment_size = options.fragment_size;
  DDSSEC_ASSIGN_OR_RETURN(config.first_entity, random_entity(services.random));
  DDSSEC_RETURN_IF_ERROR(services.random.fill(config.address_secret.emplace()));
  for (const auto& peer : options.peers) {
    const auto address = Locator::parse(peer, 0);
    if (!address) return bad_option_error("peers", "IPv4 or IPv6 addresses", peer);
    for (int i = 0; i < DomainParticipant::kAnnouncedIndexes; ++i) {
      config.announce_to.push_back(*address);
      config.announce_to.back().port = ports::metatraffic(options.domain_id, i);
    }
  }
  if (options.multicast)
    DDSSEC_RETURN_IF_ERROR(announce_by_multicast(sockets, config, services.events));
  return config;
}

}  // namespace

static_assert(DomainParticipantOptions::kMaxFragment == MessageSender::kMaxFragment);

detail::ServiceHolder::ServiceHolder(const PluginServices& services,
                                     const DomainParticipantOptions& options)
    : service_(std::make_unique<ParticipantService>(
          services, options.own_thread,
          options.delivers_in_process ? ProcessPeers::of(options.domain_id, options.domain_tag)
                                      : std::make_shared<ProcessPeers>())) {}

detail::ServiceHolder::~ServiceHolder() = default;

DomainParticipant::DomainParticipant(DomainParticipantOptions options,
                                     const PluginServices& services)
    : ServiceHolder(services, options),
      Entity(service_->context()),
      options_(std::move(options)),
      qos_{options_.user_data},
      parts_(std::make_unique<ParticipantParts>(*this, services.events)) {}

ParticipantParts::ParticipantParts(DomainParticipant& participant, EventSink& events)
    : stores(events),
      manual_liveliness([&context = participant.context_](MonotonicTime now) {
        context.protocol().assert_liveliness(LivelinessKind::manual_by_participant, now);
      }),
      discovered(participant.context_,
                 [&participant] { return participant.check_enabled("participant"); }),
      topics(participant, participant.context_, participant.options_.announce_types),
      groups(participant, participant.context_) {}

Result<std::unique_ptr<DomainParticipant>> DomainParticipant::create(
    DomainParticipantOptions wanted, const PluginServices& services) {
  if (wanted.domain_id < 0 || wanted.domain_id > kMaxDomainId)
    return bad_option_error("domain_id", "0 to 232", std::to_string(wanted.domain_id));
  if (wanted.busy_wait < std::chrono::nanoseconds::zero() ||
      wanted.busy_wait > DomainParticipantOptions::kMaxBusyWait)
    return bad_option_error("busy_wait", "0 to 1000000 ns",
                            std::to_string(wanted.busy_wait.count()));
  DDSSEC_ASSIGN_OR_RETURN(auto interfaces, choose_interfaces(wanted.interfaces));
  // RTPS 9.3.1.5: the first two octets name the vendor.
  GuidPrefix prefix;
  DDSSEC_RETURN_IF_ERROR(services.random.fill(prefix.octets));
  std::ranges::copy(kVendorDdssec.octets, prefix.octets.begin());
  std::unique_ptr<DomainParticipant> out(new DomainParticipant(std::move(wanted), services));
  const auto& options = out->options_;
  if (!options.durability_store.empty())
    DDSSEC_RETURN_IF_ERROR(
        out->parts_->stores.open_file(options.durability_store, options.durability_store_octets,
                                      options.security.has_value(), out->context_.moment().wall));
  auto& service = *out->service_;
  DDSSEC_ASSIGN_OR_RETURN(
      auto participant_sockets,
      ParticipantSockets::open(options.domain_id, std::move(interfaces),
                               {.receive_buffer = options.receive_buffer,
                                .interfaces_may_change = options.interfaces.empty()}));
  participant_sockets->loop().busy_wait(options.busy_wait);
  service.use(std::move(participant_sockets));
  if (const auto enough = service.sockets().check_receive_buffer(); !enough)
    services.events.raise(Event(enough.error()));
  std::unique_ptr<OwnSecurity> security;
  if (options.security) {
    DDSSEC_ASSIGN_OR_RETURN(security, OwnSecurity::create(*options.security, options.domain_id,
                                                          prefix, options.domain_tag));
    prefix = security->guid().prefix;
    // It takes precedence, so that it can be changed without the program.
    if (security->busy_wait()) service.sockets().loop().busy_wait(*security->busy_wait());
  }
  out->guid_ = {prefix, kEntityIdParticipant};
  DDSSEC_ASSIGN_OR_RETURN(auto config, config_of(options, prefix, service.sockets(), services));
  config.process_peers = out->context_.process_peers();
  auto protocol =
      std::make_unique<RtpsParticipant>(std::move(config), service.sockets(), services.events);
  if (security) DDSSEC_RETURN_IF_ERROR(protocol->enable_security(std::move(security)));
  DDSSEC_RETURN_IF_ERROR(service.adopt(std::move(protocol)));
  service.follow_interfaces(options.interfaces);
  raise_joined(options, service.sockets(), services.events);
  if (options.enabled) DDSSEC_RETURN_IF_ERROR(out->enable());
  return out;
}

Status DomainParticipant::enable() {
  const std::lock_guard members(context_.members());
  bool all = false;
  {
    const auto held = lock();
    if (enabled()) return {};
    mark_enabled();
    all = qos_.autoenable_created_entities;
  }
  DDSSEC_RETURN_IF_ERROR(service_->start());
  if (!all) return {};
  if (builtin_topics_) DDSSEC_RETURN_IF_ERROR(builtin_topics_->subscriber().enable());
  DDSSEC_RETURN_IF_ERROR(parts_->topics.enable());
  return parts_->groups.enable();
}

DomainParticipant::~DomainParticipant() {
  const auto quiet = NoCallbacks::begin_or_terminate(context_, guid_);
  if (context_.has_protocol()) parts_->groups.conclude_writers();
  service_->stop();
  builtin_topics_.reset();
  parts_->groups.release();
  parts_->topics.release();
  const auto held = lock();
  if (!context_.has_protocol()) return;
  if (enabled()) context_.protocol().leave();
  context_.leave();
}

int DomainParticipant::index() const { return service_->sockets().index(); }

void DomainParticipant::poll(std::chrono::nanoseconds timeout) { service_->serve(timeout); }

DomainParticipantCounters DomainParticipant::counters() const {
  const auto held = lock();
  const auto& protocol = context_.protocol();
  return {protocol.counters(), protocol.protection_counters(), protocol.authentication_counters(),
          protocol.remote_participants().size(), service_->exceptions()};
}

DomainParticipantQos DomainParticipant::qos() const {
  const auto held = lock();
  return qos_;
}

void DomainParticipant::set_qos(const DomainParticipantQos& qos) {
  const auto held = lock();
  if (qos.user_data != qos_.user_data)
    context_.protocol().change_own({.user_data = qos.user_data}, context_.now());
  qos_ = qos;
  context_.reschedule();
}

void DomainParticipant::set_listener(DomainParticipantListener* listener, StatusMask mask) {
  replace_listener([&] { return listening_.set(listener, mask); });
}

Qos DomainParticipant::default_topic_qos() const {
  const auto held = lock();
  return default_topic_qos_;
}

Status DomainParticipant::set_default_topic_qos(const Qos& qos) {
  DDSSEC_RETURN_IF_ERROR(check_consistency(qos));
  const auto held = lock();
  default_topic_qos_ = qos;
  return {};
}

Result<Topic*> DomainParticipant::create_topic(std::string name, TypeSupport type,
                                               std::optional<Qos> qos, TopicListener* listener,
                                               StatusMask mask) {
  return parts_->topics.create(std::move(name), std::move(type),
                               std::move(qos).value_or(default_topic_qos()), listener, mask);
}

Topic* DomainParticipant::lookup_topicdescription(std::string_view name) const {
  return parts_->topics.lookup(name);
}

Result<ContentFilteredTopic*> DomainParticipant::create_contentfilteredtopic(std::string name,
                                                                             Topic& related,
                                                                             FilterText filter) {
  return parts_->topics.create_filtered(std::move(name), related, std::move(filter));
}

ContentFilteredTopic* DomainParticipant::lookup_contentfilteredtopic(std::string_view name) const {
  return parts_->topics.lookup_filtered(name);
}

Status DomainParticipant::delete_contentfilteredtopic(ContentFilteredTopic& topic) {
  return parts_->topics.remove(topic);
}

Result<Topic*> DomainParticipant::find_topic(const std::string& name,
                                             std::chrono::nanoseconds timeout) {
  return parts_->topics.find(name, timeout);
}

Status DomainParticipant::delete_topic(Topic& topic) { return parts_->topics.remove(topic); }

Publisher& DomainParticipant::create_publisher(GroupQos qos, PublisherListener* listener,
                                               StatusMask mask) {
  return parts_->groups.create_publisher(std::move(qos), listener, mask);
}

Subscriber& DomainParticipant::create_subscriber(GroupQos qos, SubscriberListener* listener,
                                                 StatusMask mask) {
  return parts_->groups.create_subscriber(std::move(qos), listener, mask);
}

Status DomainParticipant::delete_publisher(Publisher& publisher) {
  return parts_->groups.remove(publisher);
}

Status DomainParticipant::delete_subscriber(Subscriber& subscriber) {
  return parts_->groups.remove(subscriber);
}

Status DomainParticipant::delete_contained_entities() {
  DDSSEC_ASSIGN_OR_RETURN(const auto quiet, NoCallbacks::begin(context_));
  parts_->groups.conclude_writers();
  const std::lock_guard members(context_.members());
  const auto topics = parts_->topics.release();
  parts_->groups.release();  // released before the topics, to which their members refer
  return {};
}

bool DomainParticipant::contains_entities() const {
  const auto held = lock();
  return !parts_->topics.empty() || !parts_->groups.empty();
}

Subscriber& DomainParticipant::builtin_subscriber() {
  const std::lock_guard members(context_.members());
  auto& topics = BuiltinTopics::of(builtin_topics_, *this, context_);
  topics.make<ParticipantBuiltinTopicData>();
  topics.make<TopicBuiltinTopicData>();
  topics.make<PublicationBuiltinTopicData>();
  topics.make<SubscriptionBuiltinTopicData>();
  return topics.subscriber();
}

std::vector<Guid> DomainParticipant::discovered_participants() const {
  return parts_->discovered.participants();
}

Result<ParticipantBuiltinTopicData> DomainParticipant::discovered_participant_data(
    const Guid& participant) const {
  return parts_->discovered.participant_data(participant);
}

std::vector<TopicBuiltinTopicData> DomainParticipant::discovered_topics() const {
  return parts_->discovered.topics();
}

Status DomainParticipant::ignore_participant(const Guid& participant) {
  return parts_->discovered.ignore_participant(participant);
}

Status DomainParticipant::ignore_topic(const std::string& name) {
  return parts_->discovered.ignore_topic(name);
}

Status DomainParticipant::ignore_publication(const Guid& writer) {
  return parts_->discovered.ignore_endpoint(writer);
}

Status DomainParticipant::ignore_subscription(const Guid& reader) {
  return parts_->discovered.ignore_endpoint(reader);
}

Status DomainParticipant::revise_keys() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("participant"));
  const auto status = context_.protocol().revise_keys();
  context_.reschedule();
  return status;
}

Status DomainParticipant::assert_liveliness() {
  const auto held = lock();
  DDSSEC_RETURN_IF_ERROR(check_enabled("participant"));
  parts_->manual_liveliness.assert_all(context_.now(), true);
  context_.reschedule();
  return {};
}

}  // namespace ddssec::rtps
