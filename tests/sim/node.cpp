#include "tests/sim/node.hpp"

#include "wire/span_writer.hpp"

namespace ddssec::rtps::sim {
namespace {

// Counts the calls that cost public-key work.
class CountedAuthentication final : public testing::ForwardingAuthentication {
 public:
  CountedAuthentication(std::unique_ptr<spi::Authentication> real, std::size_t& begun)
      : ForwardingAuthentication(std::move(real)), begun_(begun) {}
  Result<HandshakeStep> begin_handshake_request(spi::IdentityHandle initiator,
                                                spi::IdentityHandle replier,
                                                BytesView data) override {
    ++begun_;
    return ForwardingAuthentication::begin_handshake_request(initiator, replier, data);
  }

 private:
  std::size_t& begun_;
};

EndpointDescription request_of(const End& end) {
  Qos qos = end.writes ? default_writer_qos() : default_reader_qos();
  qos.reliability.kind = end.is_reliable ? ReliabilityKind::reliable : ReliabilityKind::best_effort;
  qos.history.kind = HistoryKind::keep_all;
  if (end.durable) {
    qos.durability = DurabilityKind::transient_local;
    if (end.writes) qos.history = {HistoryKind::keep_last, 1};
  }
  if (end.topic == kTopics[0]) qos.liveliness.lease_duration = Duration{{3, 0}};
  if (!end.writes) qos.liveliness.lease_duration = kDurationInfinite;
  return {std::string(end.topic), "ShapeType", std::move(qos), true};
}

}  // namespace

void Endpoint::is_known_as(const Guid& guid) {
  end_.guid = guid;
  if (end_.subject->role == Role::impostor) return;  // it is the name of another participant
  around_.invariants.on_started(end_);
}

bool Endpoint::has_honest_peers_only() const {
  return std::ranges::all_of(matched_, [this](const auto& one) {
    const auto* life = around_.ledger.life(one.first.prefix);
    return life != nullptr && life->subject->is_honest();
  });
}

MonotonicTime Endpoint::matched_since(const Guid& remote) const {
  const auto at = matched_.find(remote);
  return at == matched_.end() ? kNever : at->second;
}

void Endpoint::on_matched(const EndpointData& remote) {
  const FreeOfCharge simulation;
  matched_.try_emplace(remote.guid, around_.now);
  around_.invariants.on_matched(end_, remote.guid);
}

void Endpoint::on_unmatched(const Guid& remote) {
  const FreeOfCharge simulation;
  matched_.erase(remote);
  signals_.erase(remote);
  around_.invariants.on_unmatched(end_, remote);
}

bool Endpoint::on_change(Change& change) {
  const FreeOfCharge simulation;
  around_.invariants.on_delivered(end_, change);
  got_.insert({change.writer, change.sequence_number});
  return true;
}

void Endpoint::on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) {
  const FreeOfCharge simulation;
  signals_[writer] = signal;
  if (signal) signal->notify(*this, writer);
}

void Endpoint::on_alive(const Guid& writer) {
  const FreeOfCharge simulation;
  around_.invariants.on_alive(end_, writer);
  if (const auto& signal = signals_[writer]) signal->notify(*this, writer);
}

Node::Node(const Surroundings& around, const Subject& subject, std::size_t number, Dice dice)
    : around_(around),
      subject_(subject),
      address_(address_of(number)),
      dice_(dice),
      random_(dice_.next()) {}

void Node::make_plugins(const GuidPrefix& name) {
  const PluginServices services{clock_, random_, *this};
  plugins_ = {authentication::make_authentication(services),
              access_control::make_access_control(services, {.host_revises_keys = true,
                                                             .host_has_pre_shared_keys = true,
                                                             .host_changes_protection = true}),
              cryptography::make_cryptography(services)};
  if (subject_.is_honest()) {
    plugins_.authentication =
        std::make_unique<CountedAuthentication>(std::move(plugins_.authentication), handshakes_);
    return;
  }
  const bool borrows = subject_.role == Role::borrower;
  plugins_.access_control =
      permissive(std::move(plugins_.access_control),
                 borrows ? honest_permissions(around_.protection) : std::string());
  plugins_.cryptography = tampering(std::move(plugins_.cryptography), around_.malice);
  if (subject_.role == Role::impostor)
    plugins_.authentication = under_false_name(std::move(plugins_.authentication), name);
}

ParticipantConfig Node::config(const GuidPrefix& prefix) {
  ParticipantConfig out{.prefix = prefix,
                        .domain_tag = subject_.domain_tag(),
                        .metatraffic_unicast = {address()},
                        .default_unicast = {address()},
                        .announce_to = {kGroup},
                        .address_secret = sha256(prefix.octets)};
  auto here = address();
  here.port = 0;
  if (around_.has_interfaces) out.interfaces = {{"net0", here, 16, true}};
  out.first_entity = static_cast<std::uint32_t>(1 + dice_.below(1000));
  return out;
}

void Node::start(const GuidPrefix& name) {
  const Charge charge(cost_);
  make_plugins(name);
  const auto candidate = GuidPrefix::from(dice_.octets(12));
  auto own = OwnSecurity::create(
      {{*plugins_.authentication, *plugins_.access_control, *plugins_.cryptography},
       properties_of(subject_, around_.protection)},
      0, candidate, subject_.domain_tag());
  if (!own) return around_.invariants.fail("a participant starts", own.error().to_sentence());
  const auto prefix = (*own)->guid().prefix;
  Transport& transport = *this;
  EventSink& events = *this;
  participant_ = std::make_unique<RtpsParticipant>(config(prefix), transport, events);
  if (const auto secured = participant_->enable_security(std::move(*own)); !secured)
    return around_.invariants.fail("a participant starts", secured.error().to_sentence());
  if (subject_.role != Role::impostor)
    around_.ledger.enter(prefix, {&subject_, around_.now, kNever});
  if (is_sibling()) return;
  for (const auto topic : kTopics)
    for (const bool writes : {true, false}) add_endpoint(topic, writes);
}

void Node::stop(bool says_so) {
  if (!participant_) return;
  const Charge charge(cost_);
  if (says_so) participant_->leave();
  if (subject_.role != Role::impostor) around_.ledger.leave(prefix(), around_.now);
  participant_.reset();
  endpoints_.clear();
  plugins_ = {};
  in_socket_.clear();
  asleep_until_ = {};
}

void Node::add_endpoint(std::string_view topic, bool writes) {
  add_endpoint(End{&subject_, topic, writes, {}, around_.now});
}

void Node::add_durable_reader(std::string_view topic, bool reliable) {
  add_endpoint(End{&subject_, topic, false, {}, around_.now, true, reliable});
}

// Writes one sample of one instance, and then many of another one.
void Node::add_sparse_writer(std::string_view topic, std::int64_t numbers) {
  for (std::size_t i = endpoints_.size(); i-- > 0;)
    if (const auto& end = endpoints_[i]->end(); !end.writes && end.topic == topic)
      remove_endpoint(i);
  add_endpoint(End{&subject_, topic, true, {}, around_.now, true});
  const Charge charge(cost_);
  const auto guid = endpoints_.back()->end().guid;
  auto* writer = participant_->local_endpoints().writer(guid);
  if (writer == nullptr) return;
  const auto time = Time::from(clock_.calendar_nanoseconds());
  for (std::int64_t number = 1; number <= numbers; ++number) {
    const bool stays = number == 1 || number == numbers;
    const auto octets = stays ? payload_of(guid, {number}) : Bytes{0, 1, 0, 0};
    if (stays) around_.ledger.hold(guid, {number}, {topic, octets, {}, time, around_.now});
    Change change;
    change.source_time = time;
    change.key_hash = KeyHash{static_cast<std::uint8_t>(number == 1)};
    change.payload = Payload::copy_of(octets);
    writer->write(std::move(change), around_.now);
  }
}

void Node::add_endpoint(const End& end) {
  const Charge charge(cost_);
  auto endpoint = std::make_unique<Endpoint>(around_, end);
  auto request = request_of(end);
  const auto guid = end.writes
                        ? participant_->create_writer(std::move(request), *endpoint, around_.now)
                        : participant_->create_reader(std::move(request), *endpoint, around_.now);
  if (!guid) return;
  endpoint->is_known_as(*guid);
  endpoints_.push_back(std::move(endpoint));
}

void Node::remove_endpoint(std::size_t index) {
  const Charge charge(cost_);
  participant_->remove(endpoints_[index]->end().guid, around_.now);
  endpoints_.erase(endpoints_.begin() + static_cast<std::ptrdiff_t>(index));
}

void Node::call(std::size_t octets, const std::function<void()>& what) {
  const auto before = cost_;
  handshakes_ = 0;
  {
    const Charge charge(cost_);
    what();
  }
  around_.invariants.on_call(subject_, before, cost_, octets);
  around_.invariants.on_handshakes(subject_, handshakes_);
}

void Node::receive(const Datagram& datagram) {
  if (!participant_) return;
  if (asleep_until_ > around_.now) {
    if (in_socket_.size() < kMaxInSocket) in_socket_.push_back(datagram);
    return;
  }
  call(datagram.octets.size(),
       [&] { participant_->receive(datagram.octets, around_.now, datagram.from); });
}

void Node::advance(MonotonicTime by) {
  clock_.advance(by);
  if (!participant_ || asleep_until_ > around_.now) return;
  for (const auto& datagram : std::exchange(in_socket_, {})) receive(datagram);
  if (participant_->next_tick() <= around_.now) call(0, [&] { participant_->tick(around_.now); });
}

void Node::send(BytesView message, std::span<const Locator> to) {
  const FreeOfCharge simulation;
  around_.invariants.on_sent(subject_, message);
  for (const auto& locator : to)
    around_.wire.carry(subject_, {address(), locator, to_bytes(message)}, writes_for_honest_);
}

void Node::raise(const Event& event) {
  const FreeOfCharge simulation;
  ++events_[event.error.code()];
}

Bytes Node::payload_of(const Guid& writer, SequenceNumber number) {
  constexpr std::array<std::size_t, 6> kSizes = {100, 104, 200, 1000, 20'000, 60'000};
  auto octets = dice_.octets(dice_.of(kSizes));
  SpanWriter out(octets);
  out.write_bytes(std::array<std::uint8_t, 4>{0, 1, 0, 0});
  out.write_bytes(as_bytes(kMark));
  out.write_bytes(writer.octets());
  out.write(number.value);
  return octets;
}

void Node::write(Endpoint& endpoint) {
  const auto& guid = endpoint.end().guid;
  auto* writer = participant_->local_endpoints().writer(guid);
  if (writer == nullptr || !endpoint.end().writes || endpoint.end().durable) return;
  const SequenceNumber number{around_.ledger.count(guid) + 1};
  const auto octets = payload_of(guid, number);
  if (!writer->history().has_room(octets.size())) return;
  const auto time = Time::from(clock_.calendar_nanoseconds());
  StatusInfo status;
  status.disposed = dice_.chance(100);
  if (subject_.is_honest())
    around_.ledger.write(guid, {endpoint.end().topic, octets, status, time, around_.now});
  writes_for_honest_ = subject_.is_honest() && endpoint.has_honest_peers_only();
  call(octets.size(), [&] {
    Change change;
    change.source_time = time;
    change.status = status;
    change.is_key_only = status.disposed;
    change.payload = Payload::copy_of(octets);
    if (writer->write(std::move(change), around_.now) != number && subject_.is_honest())
      around_.invariants.fail("sequence numbers have no holes", subject_.name);
  });
  writes_for_honest_ = false;
}

}  // namespace ddssec::rtps::sim
