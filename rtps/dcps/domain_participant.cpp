#include "rtps/dcps/domain_participant.hpp"

#include <fmt/format.h>

#include "base/background_thread.hpp"

namespace ddssec::rtps {
namespace {

constexpr DomainId kGreatestDomain = 232;  // its ports still fit 16 bits

std::unexpected<Error> bad_option(std::string field, std::string expected, std::string found) {
  return fail(Code::invalid_property, {.document = "participant options",
                                       .field = std::move(field),
                                       .expected = std::move(expected),
                                       .found = std::move(found)});
}

Result<std::uint32_t> random_entity(Random& random) {
  std::array<std::uint8_t, 3> octets{};
  DDSSEC_TRY(random.fill(octets));
  const auto number = std::uint32_t{octets[0]} << 16 | std::uint32_t{octets[1]} << 8 | octets[2];
  return 1 + number % ParticipantConfig::kGreatestFirstEntity;
}

Locator with_port(Locator locator, std::uint32_t port) {
  locator.port = port;
  return locator;
}

}  // namespace

/// The participant's sockets: one for discovery, one for user data, one for a multicast group, and
/// one for each further interface, by which messages to the group leave.
class DomainParticipant::Sockets final : public Transport {
 public:
  Sockets(EventLoop loop, UdpSocket metatraffic, UdpSocket user,
          const std::vector<NetworkInterface>& interfaces)
      : loop_(std::move(loop)), interfaces_(interfaces) {
    sockets_.push_back(std::move(metatraffic));
    sockets_.push_back(std::move(user));
  }

  void send(BytesView message, std::span<const Locator> to) override {
    send_all({{&message, 1}, to});
  }
  // To an address as the routes say; to a group by each interface, or by the one that is named.
  void send_all(const Outgoing& out) override {
    if (interfaces_.size() == 1 || std::ranges::none_of(out.to, &Locator::is_multicast))
      return sockets_.front().send_all(out);
    for (const auto& to : out.to) {
      const Outgoing one{out.messages, {&to, 1}, out.dscp};
      if (!to.is_multicast() || leaves_by(sockets_.front(), out.interface))
        sockets_.front().send_all(one);
      for (const auto& further : further_)
        if (to.is_multicast() && leaves_by(further, out.interface)) further.send_all(one);
    }
  }
  bool stays_here(const Locator& to) const override {
    return to.is_loopback() || std::ranges::any_of(interfaces_, [&](const auto& interface) {
             return interface.address.address == to.address;
           });
  }
  /// Errors: rtps_no_multicast, those of UdpSocket::bind.
  Status join(const Locator& group, const Locator& interface) {
    if (sockets_.size() == kWithoutGroup)
      sockets_.push_back(DDSSEC_TRY(UdpSocket::join(group, interface)));
    else
      DDSSEC_TRY(sockets_.back().join_also(group, interface));
    if (interface.address != interfaces_.front().address.address)
      further_.push_back(DDSSEC_TRY(UdpSocket::everywhere(interface)));
    return {};
  }
  bool has_joined() const { return sockets_.size() > kWithoutGroup; }
  /// `f(socket)` whenever it has something to read from now on.
  Status listen(std::function<void(UdpSocket&)> f) {
    receive_ = std::move(f);
    for (auto& socket : sockets_)
      DDSSEC_TRY(loop_.watch(socket.fd(), [this, &socket] { receive_(socket); }));
    return {};
  }
  EventLoop& loop() { return loop_; }
  /// By all interfaces.
  LocatorList metatraffic() const { return everywhere(sockets_[0].local().port); }
  LocatorList user() const { return everywhere(sockets_[1].local().port); }
  Status check_receive_buffer() const { return sockets_[1].check_receive_buffer(); }

 private:
  static constexpr std::size_t kWithoutGroup = 2;
  bool leaves_by(const UdpSocket& socket, std::size_t interface) const {
    return interface == kEveryInterface ||
           interfaces_[interface].address.address == socket.local().address;
  }
  LocatorList everywhere(std::uint32_t port) const {
    LocatorList out;
    for (const auto& interface : interfaces_) out.push_back(with_port(interface.address, port));
    return out;
  }

  EventLoop loop_;
  const std::vector<NetworkInterface>& interfaces_;
  std::vector<UdpSocket> sockets_, further_;
  std::function<void(UdpSocket&)> receive_;
};

DomainParticipant::DomainParticipant(DomainParticipantOptions options,
                                     const Environment& environment)
    : ContextHolder(environment, *this, options),
      Entity(own_context_),
      options_(std::move(options)),
      qos_{options_.user_data},
      stores_(environment.events),
      manual_liveliness_([this](MonotonicTime now) {
        context_.protocol().assert_liveliness(LivelinessKind::manual_by_participant, now);
      }) {}

Result<std::unique_ptr<DomainParticipant>> DomainParticipant::create(
    DomainParticipantOptions options, const Environment& environment) {
  if (options.domain_id < 0 || options.domain_id > kGreatestDomain)
    return bad_option("domain_id", "0 to 232", std::to_string(options.domain_id));
  auto interfaces = DDSSEC_TRY(choose_interfaces(options.interfaces));
  // RTPS 9.3.1.5: the first two octets name the vendor.
  GuidPrefix prefix;
  DDSSEC_TRY(environment.random.fill(prefix.octets));
  std::ranges::copy(kVendorDdssec.octets, prefix.octets.begin());
  std::unique_ptr<DomainParticipant> out(new DomainParticipant(std::move(options), environment));
  out->interfaces_ = std::move(interfaces);
  if (const auto& options = out->options_; !options.durability_store.empty())
    DDSSEC_TRY(out->stores_.open_file(options.durability_store, options.durability_store_octets));
  DDSSEC_TRY(out->open_sockets());
  std::unique_ptr<OwnSecurity> security;
  if (const auto& wanted = out->options_.security) {
    security = DDSSEC_TRY(
        OwnSecurity::create(*wanted, out->options_.domain_id, prefix, out->options_.domain_tag));
    prefix = security->guid().prefix;
  }
  DDSSEC_TRY(out->start(prefix, std::move(security)));
  environment.events.raise(out->joined());
  if (out->options_.enabled) DDSSEC_TRY(out->enable());
  return out;
}

Event DomainParticipant::joined() const {
  const std::string_view multicast =
      sockets_->has_joined() ? "with multicast" : "without multicast";
  const bool alone = std::ranges::all_of(
      interfaces_, [](const auto& interface) { return interface.address.is_loopback(); });
  return Event(
      Error(Code::rtps_joined,
            {.note = fmt::format("domain {} on {}, {}{}", domain_id(), to_string(interfaces_),
                                 multicast, alone ? "; no other machine is reached" : "")}));
}

// A loopback alone is not reached from elsewhere.
Result<UdpSocket> DomainParticipant::open_socket(std::uint32_t port) const {
  const auto first = with_port(interfaces_.front().address, port);
  return interfaces_.size() == 1 ? UdpSocket::on_interface(first, options_.receive_buffer)
                                 : UdpSocket::everywhere(first, options_.receive_buffer);
}

// The first index of which both ports are free.
Status DomainParticipant::open_sockets() {
  const auto domain = options_.domain_id;
  for (index_ = 0; index_ < ports::kMostIndexes; ++index_) {
    auto metatraffic = open_socket(ports::metatraffic(domain, index_));
    if (!metatraffic && metatraffic.error().code() == Code::rtps_port_taken) continue;
    if (!metatraffic) return std::unexpected(metatraffic.error());
    auto user = open_socket(ports::user(domain, index_));
    if (!user && user.error().code() == Code::rtps_port_taken) continue;
    if (!user) return std::unexpected(user.error());
    sockets_ = std::make_unique<Sockets>(DDSSEC_TRY(EventLoop::create()), std::move(*metatraffic),
                                         std::move(*user), interfaces_);
    if (const auto enough = sockets_->check_receive_buffer(); !enough)
      context_.environment().events.raise(Event(enough.error()));
    return {};
  }
  return fail(Code::rtps_port_taken, {.document = to_string(interfaces_),
                                      .field = "participant index",
                                      .expected = "a free one below 120",
                                      .found = "all taken"});
}

Status DomainParticipant::start(const GuidPrefix& prefix, std::unique_ptr<OwnSecurity> security) {
  guid_ = {prefix, kEntityIdParticipant};
  ParticipantConfig config{.prefix = prefix,
                           .domain_id = options_.domain_id,
                           .domain_tag = options_.domain_tag,
                           .entity_name = options_.entity_name,
                           .user_data = options_.user_data,
                           .lease_duration = options_.lease_duration,
                           .metatraffic_unicast = sockets_->metatraffic(),
                           .default_unicast = sockets_->user(),
                           .interfaces = interfaces_,
                           .neighbourhood = context_.neighbourhood()};
  config.announcement_period = options_.announcement_period;
  config.fragment_size = options_.fragment_size;
  config.first_entity = DDSSEC_TRY(random_entity(context_.environment().random));
  for (const auto& peer : options_.peers) {
    const auto address = Locator::parse(peer, 0);
    if (!address) return bad_option("peers", "IPv4 or IPv6 addresses", peer);
    for (int i = 0; i < kAnnouncedIndexes; ++i)
      config.announce_to.push_back(with_port(*address, ports::metatraffic(options_.domain_id, i)));
  }
  if (options_.multicast) DDSSEC_TRY(announce_by_multicast(config));
  auto protocol =
      std::make_unique<Participant>(std::move(config), *sockets_, context_.environment().events);
  if (security) DDSSEC_TRY(protocol->secure(std::move(security)));
  const auto held = lock();
  context_.adopt(std::move(protocol));
  return sockets_->listen([this](UdpSocket& socket) {
    const auto count = socket.fetch();
    context_.serve([&] {
      const auto now = context_.now();
      const auto gathering = context_.protocol().gather();
      for (std::size_t i = 0; i < count; ++i)
        context_.protocol().receive(socket.datagram(i), now, socket.source(i));
      context_.protocol().note_backlog(count == UdpSocket::kBatch);
    });
  });
}

Status DomainParticipant::announce_by_multicast(ParticipantConfig& config) {
  const auto group = Locator::udp_v4({239, 255, 0, 1},
                                     static_cast<std::uint16_t>(ports::base(options_.domain_id)));
  for (const auto& interface : interfaces_) {
    const auto joined = sockets_->join(group, interface.address);
    if (joined) continue;
    // With peers to announce to, others are found all the same.
    if (interfaces_.size() == 1 && config.announce_to.empty()) return joined;
    context_.environment().events.raise(Event(joined.error().in(to_string({&interface, 1}))));
  }
  if (!sockets_->has_joined()) return {};
  config.metatraffic_multicast = {group};
  config.announce_to.push_back(group);
  return {};
}

Status DomainParticipant::enable() {
  const std::lock_guard members(context_.callbacks());
  bool all = false;
  {
    const auto held = lock();
    if (enabled()) return {};
    mark_enabled();
    all = qos_.autoenable_created_entities;
  }
  if (options_.own_thread) {
    const auto held = lock();
    context_.protocol().allow_lingering();
    thread_ = start_background_thread<std::thread>([this] {
      while (!stopping_) serve(std::chrono::seconds(10));
    });
  }
  if (!all) return {};
  if (builtin_topics_) DDSSEC_TRY(builtin_topics_->subscriber().enable());
  for (auto& topic : topics_) DDSSEC_TRY(topic->enable());
  for (auto& publisher : publishers_) DDSSEC_TRY(publisher->enable());
  for (auto& subscriber : subscribers_) DDSSEC_TRY(subscriber->enable());
  return {};
}

DomainParticipant::~DomainParticipant() {
  if (context_.has_protocol()) conclude();
  stopping_ = true;
  if (sockets_) wake();
  if (thread_.joinable()) thread_.join();
  builtin_topics_.reset();
  subscribers_.clear();
  publishers_.clear();
  filtered_topics_.clear();
  topics_.clear();
  const auto held = lock();
  if (!context_.has_protocol()) return;
  if (enabled()) context_.protocol().leave();
  context_.leave();
}

void DomainParticipant::wake() { sockets_->loop().wake(); }

void DomainParticipant::serve(std::chrono::nanoseconds most) {
  std::optional<MonotonicTime> until;
  context_.serve([&] {
    if (enabled()) until = context_.tick(most);
  });
  if (!until) return;
  if (context_.dispatch()) {
    const auto held = lock();
    until = context_.next();
  }
  sockets_->loop().wait(std::max(*until - context_.now(), MonotonicTime::zero()));
  context_.dispatch();
}

ParticipantCounters DomainParticipant::counters() const {
  const auto held = lock();
  return context_.protocol().counters();
}

ProtectionCounters DomainParticipant::protection_counters() const {
  const auto held = lock();
  return context_.protocol().protection_counters();
}

AuthenticationCounters DomainParticipant::authentication_counters() const {
  const auto held = lock();
  return context_.protocol().authentication_counters();
}

std::size_t DomainParticipant::remote_participants() const {
  const auto held = lock();
  return context_.protocol().remote_participants().size();
}

}  // namespace ddssec::rtps
