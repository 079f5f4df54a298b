#include "rtps/security/governance_transition.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

using GovernanceReport = GovernanceOfPeer::GovernanceReport;

constexpr std::string_view kClass = "org.ddssec.governance";
constexpr std::string_view kVersion = "org.ddssec.governance.version";
constexpr std::string_view kWantsAnswer = "org.ddssec.governance.wants_answer";
constexpr std::size_t kOctets = 4 + 32 + 1;  // revision, digest, state

spi::Token token_of(const GovernanceReport& report, bool wants_answer) {
  Writer octets;
  octets.write(report.version.revision);
  octets.write_bytes(report.version.digest);
  octets.write(static_cast<std::uint8_t>(report.state));
  spi::Token token{.class_id = std::string(kClass)};
  token.binary_properties.push_back({std::string(kVersion), to_bytes(octets.view()), true});
  if (wants_answer) token.properties.push_back({std::string(kWantsAnswer), "true", true});
  return token;
}

std::optional<GovernanceReport> report_in(const spi::Token& token) {
  const auto* octets = spi::find_binary_property(token, kVersion);
  if (token.class_id != kClass || octets == nullptr || octets->size() != kOctets) return {};
  const BytesView all(*octets);
  if (all.back() > static_cast<std::uint8_t>(GovernanceOfPeer::State::in_force)) return {};
  GovernanceReport out;
  for (const auto octet : all.first(4)) out.version.revision = out.version.revision << 8 | octet;
  std::ranges::copy(all.subspan(4, out.version.digest.size()), out.version.digest.begin());
  out.state = static_cast<GovernanceOfPeer::State>(all.back());
  return out;
}

}  // namespace

GovernanceTransition::GovernanceTransition(SecurityCore& core, Admission& admission,
                                           CryptoTokenExchange& exchange, KeyReviser& revision)
    : core_(core), admission_(admission), exchange_(exchange), revision_(revision) {
  exchange.on_governance([this](Peer& peer, const GenericMessage& message) {
    if (message.data.size() == 1) on_message(peer, message.data[0]);
  });
}

template <class F>
void GovernanceTransition::each_joined(F&& f) {
  for (auto& [prefix, peer] : core_.peers)
    if (peer.state.joined() != nullptr) f(peer);
}

// ---- phases

void GovernanceTransition::tick() {
  if (phase_ != Phase::draining) check();
  if (phase_ == Phase::none) return send_to_all();
  // The protections are added before the reports are sent, because peers that receive a report send
  // keys for the second protection at once.
  if (phase_ == Phase::accepting && !add_protections()) return;
  send_to_all();
  const bool is_complete = complete_pairs();
  if (phase_ == Phase::accepting) {
    const bool all_are_ready =
        is_complete &&
        std::ranges::all_of(core_.peers, [&](const auto& one) { return is_ready(one.second); });
    if (all_are_ready || core_.now >= deadline_) change();
  } else {
    const bool any_is_behind = std::ranges::any_of(core_.peers, [&](const auto& one) {
      const auto* association = one.second.state.association();
      return association != nullptr && association->governance.takes_part &&
             (association->governance.received->state == State::changing ||
              core_.keyring.second_protections().any_announced_with_second(one.first));
    });
    if (!any_is_behind || core_.now >= deadline_) end();
  }
}

void GovernanceTransition::check() {
  const auto next =
      core_.own->plugins().access_control.pending_governance(core_.own->permissions());
  if (phase_ == Phase::accepting && next != target_)
    end();  // the CA of the document has left;
            // another document may wait
  core_.governance_waits = next.has_value();
  if (!next) waits_since_.reset();
  if (phase_ == Phase::none && next && may_begin()) begin(*next);
}

// A change waits for a revision that is under way, because its keys are for the first protection.
// An insider may cause revisions without end, so it waits no longer than its own time.
bool GovernanceTransition::may_begin() {
  if (!waits_since_) waits_since_ = core_.now;
  return !revision_.is_busy() || core_.now >= *waits_since_ + core_.own->governance_change_time();
}

// Keys of the second protection are not revised. From now on they are not used to send, and they
// are accepted no longer than former keys.
void GovernanceTransition::finish() {
  if (phase_ == Phase::accepting && add_protections()) change();
  if (phase_ == Phase::draining)
    deadline_ = std::min(deadline_, core_.now + 2 * KeyReviser::kTimeout);
}

void GovernanceTransition::begin(const Version& next) {
  target_ = next;
  phase_ = Phase::accepting;
  has_failed_ = false;
  has_lost_any_ = false;
  core_.governance_changes = true;
  waits_since_.reset();
  deadline_ = core_.now + core_.own->governance_change_time();
  each_joined([&](Peer& peer) { refresh(peer); });
  judge_matches();
}

// Fails if the document was dropped meanwhile, because its CA has left.
void GovernanceTransition::change() {
  auto& access = core_.own->plugins().access_control;
  if (!access.apply_pending_governance(core_.own->permissions(), *target_)) return end();
  report_behind();
  core_.sender.flush();
  core_.keyring.second_protections().swap();
  core_.governance_has_changed = true;
  phase_ = Phase::draining;
  // A peer that has the document sends with the new protection before its own time is over.
  deadline_ = core_.now + core_.own->governance_change_time() + kMargin;
  send_to_all();
  admission_.announce_protection();
  judge_matches();
}

void GovernanceTransition::end() {
  core_.keyring.second_protections().remove_all();
  core_.governance_changes = core_.governance_waits = false;
  phase_ = Phase::none;
  deadline_ = kNever;
  each_joined([&](Peer& peer) { refresh(peer); });
  send_to_all();
  judge_matches();
  if (std::exchange(has_lost_any_, false))
    revision_.request(KeyReviser::RevisionReason::right_lost);
}

bool GovernanceTransition::add_protections() {
  for (const auto& [id, topic] : admission_.own_topics()) {
    const auto status = admission_.add_other_protection(id, topic);
    if (status) continue;
    if (!std::exchange(has_failed_, true))
      core_.events.raise(Event(status.error().with_document("topic " + topic)));
    return false;
  }
  return true;
}

bool GovernanceTransition::complete_pairs() {
  bool all = true;
  each_joined([&](Peer& peer) {
    if (peer.state.association()->governance.takes_part)
      all = exchange_.complete_pairs(peer) && all;
  });
  return all;
}

bool GovernanceTransition::has_changed(const Peer& peer) const {
  const auto* association = peer.state.association();
  return association != nullptr && association->governance.received &&
         association->governance.received->version == own().version;
}

// A peer that has not joined gets its keys later, so nothing waits for it.
bool GovernanceTransition::is_ready(const Peer& peer) const {
  if (peer.state.joined() == nullptr || !core_.keyring.second_protections().any_with(peer.prefix()))
    return true;
  return has_changed(peer) && CryptoTokenExchange::is_up_to_date(peer);
}

void GovernanceTransition::refresh(Peer& peer) const {
  auto* association = peer.state.association();
  if (association == nullptr) return;
  association->governance.takes_part = has_changed(peer);
}

void GovernanceTransition::report_behind() {
  each_joined([&](Peer& peer) {
    if (!core_.keyring.second_protections().any_with(peer.prefix()) || has_changed(peer)) return;
    const auto& report = peer.state.association()->governance.received;
    const bool is_ahead = report && report->version.revision > target_->revision;
    core_.raise(
        Error(
            is_ahead ? Code::governance_peer_ahead : Code::governance_peer_behind,
            {.document = "governance",
             .field = "revision",
             .expected = std::to_string(target_->revision),
             .found = report ? std::to_string(report->version.revision) : "an earlier one or none",
             .note = "its endpoints no longer match on topics that the two documents protect "
                     "differently"}),
        peer, EventOrigin::its_keys);
  });
}

void GovernanceTransition::judge_matches() {
  std::vector<GuidPrefix> prefixes;
  each_joined([&](Peer& peer) { prefixes.push_back(peer.prefix()); });
  for (const auto& prefix : prefixes)
    has_lost_any_ = core_.host.on_rights_changed(prefix) || has_lost_any_;
}

// ---- messages

GovernanceOfPeer::GovernanceReport GovernanceTransition::own() const {
  if (phase_ != Phase::none)
    return {*target_, phase_ == Phase::accepting ? State::changing : State::changed};
  const auto version =
      core_.own->plugins().access_control.governance_version(core_.own->permissions());
  return {version.value_or(Version{}), State::in_force};
}

void GovernanceTransition::send_report(Peer& peer, bool wants_answer) {
  if (peer.data.vendor != kVendorDdssec || !exchange_.has_room(peer)) return;
  auto& governance = peer.state.association()->governance;
  const auto report = own();
  if (governance.sent == report) return;
  governance.sent = report;
  exchange_.send_token(peer, message_class::kGovernance, token_of(report, wants_answer));
}

// Without a change, a peer gets a report only if it had one before or asks for one.
void GovernanceTransition::send_to_all() {
  each_joined([&](Peer& peer) {
    const auto& governance = peer.state.association()->governance;
    if (phase_ != Phase::none || governance.sent) send_report(peer, !governance.sent);
  });
}

void GovernanceTransition::on_message(Peer& peer, const spi::Token& token) {
  const auto report = report_in(token);
  auto* association = peer.state.association();
  if (!report || association == nullptr) return;
  auto& governance = association->governance;
  const bool took_part = governance.takes_part;
  governance.received = report;
  refresh(peer);
  if (spi::find_property(token.properties, kWantsAnswer) != nullptr &&
      governance.answers.try_spend(core_.now)) {
    governance.sent.reset();
    send_report(peer, false);
  }
  if (!took_part && governance.takes_part) exchange_.complete_pairs(peer);
}

}  // namespace ddssec::rtps
