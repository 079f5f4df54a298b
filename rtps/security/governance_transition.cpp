#include "rtps/security/governance_transition.hpp"

#include <algorithm>

#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using GovernanceReport = GovernanceOfPeer::GovernanceReport;

constexpr std::string_view kClass = "org.ddssec.governance";
constexpr std::string_view kVersion = "org.ddssec.governance.version";
constexpr std::string_view kWantsAnswer = "org.ddssec.governance.wants_answer";
constexpr std::string_view kWantsKeys = "org.ddssec.governance.wants_keys";
constexpr std::size_t kOctets = 4 + 32 + 1;  // revision, digest, state

spi::Token token_of(const GovernanceReport& report, bool wants_answer, bool wants_keys) {
  Bytes octets(kOctets);
  SpanWriter out(octets, Endian::big);
  out.write(report.version.revision);
  out.write_bytes(report.version.digest);
  out.write(static_cast<std::uint8_t>(report.state));
  spi::Token token{.class_id = std::string(kClass)};
  token.binary_properties.push_back({std::string(kVersion), std::move(octets), true});
  if (wants_answer) token.properties.push_back({std::string(kWantsAnswer), "true", true});
  if (wants_keys) token.properties.push_back({std::string(kWantsKeys), "true", true});
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

GovernanceTransition::GovernanceTransition(GovernanceChangeState& state, SecurityCore& core,
                                           Admission& admission, CryptoTokenExchange& exchange,
                                           KeyReviser& key_reviser)
    : state_(state),
      core_(core),
      admission_(admission),
      exchange_(exchange),
      key_reviser_(key_reviser) {
  exchange.listen({message_class::kGovernance}, [this](Peer& peer, const GenericMessage& message) {
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
  if (state_.phase() != Phase::draining) poll_document();
  each_joined([&](Peer& peer) { send_again(peer); });
  if (state_.phase() == Phase::none) return send_to_all();
  // The protections are added before the reports are sent, because peers that receive a report send
  // keys for the second protection at once.
  if (state_.phase() == Phase::accepting && !add_protections()) return;
  send_to_all();
  const bool is_complete = complete_pairs();
  if (state_.phase() == Phase::accepting) {
    const bool all_are_ready =
        is_complete &&
        std::ranges::all_of(core_.peers, [&](const auto& one) { return is_ready(one.second); });
    if (all_are_ready || core_.now >= deadline_) change();
  } else {
    const bool any_is_behind = std::ranges::any_of(core_.peers, [&](const auto& one) {
      const auto* association = one.second.state.association();
      return association != nullptr && association->governance.takes_part &&
             (association->governance.received->state == State::changing ||
              core_.keyring.phases().endpoints().any_announced_with_second(one.first));
    });
    const bool is_over = !any_is_behind && admission_.are_announcements_received();
    if (is_over || core_.now >= deadline_) end();
  }
}

void GovernanceTransition::poll_document() {
  const auto next =
      core_.own->plugins().access_control.pending_governance(core_.own->permissions());
  // The CA of the document has left; another document may wait.
  if (state_.phase() == Phase::accepting && next != state_.target()) end();
  state_.note_pending(next.has_value());
  if (!next) waits_since_.reset();
  if (state_.phase() == Phase::none && next && may_begin()) begin(*next);
}

// A change waits for a revision that is under way, because its keys are for the first protection.
// An insider may cause revisions without end, so it waits no longer than its own time.
bool GovernanceTransition::may_begin() {
  if (!waits_since_) waits_since_ = core_.now;
  return !key_reviser_.is_busy() ||
         core_.now >= *waits_since_ + core_.own->governance_change_time();
}

// Keys of the next protection are revised with the present ones, so the first phase goes on: a
// participant that dropped them would hear nothing from peers that change meanwhile. Those of the
// former protection count for no longer in the second phase than former keys do.
void GovernanceTransition::note_revision() {
  if (state_.phase() == Phase::draining)
    deadline_ = std::min(deadline_, core_.now + 2 * KeyReviser::kTimeout);
}

void GovernanceTransition::begin(const Version& next) {
  has_failed_ = has_protections_ = false;
  has_lost_any_ = false;
  auto domain =
      core_.own->plugins().access_control.participant_attributes_of(core_.own->permissions(), next);
  if (domain && spi::security_info(*domain) == spi::security_info(core_.own->attributes()))
    domain.reset();
  state_.begin(next, std::move(domain));
  deadline_ = *std::exchange(waits_since_, std::nullopt) + core_.own->governance_change_time();
  for (auto& [prefix, peer] : core_.peers) refresh(peer);
}

// Fails if the document was dropped meanwhile, because its CA has left.
void GovernanceTransition::change() {
  auto& access = core_.own->plugins().access_control;
  const auto former = access.governance_version(core_.own->permissions());
  if (!access.apply_pending_governance(core_.own->permissions(), *state_.target())) return end();
  report_behind();
  core_.sender.flush_now();  // what waits was begun with the former protection
  core_.keyring.phases().swap();
  auto domain = state_.other_domain();
  if (domain) domain = core_.own->set_attributes(*domain);
  state_.change(former, std::move(domain));
  if (state_.other_domain()) note_all_former();
  // A peer that has the document sends with the new protection before its own time is over.
  deadline_ = core_.now + core_.own->governance_change_time() + kMargin;
  send_to_all();
  admission_.announce_protection();
  rematch();
}

void GovernanceTransition::end() {
  const auto former = peers_of_former();
  core_.keyring.phases().remove_second();
  state_.end();
  admission_.end_former_announcements();
  deadline_ = kNever;
  each_joined([&](Peer& peer) { refresh(peer); });
  send_to_all();
  rematch();
  if (std::exchange(has_lost_any_, false))
    key_reviser_.request(KeyReviser::RevisionReason::right_lost);
  for (const auto& prefix : former) core_.host.on_ended(prefix);
}

bool GovernanceTransition::add_protections() {
  const auto status = add_second_protections();
  if (!status) {
    if (!std::exchange(has_failed_, true)) core_.events.raise(Event(status.error()));
    return false;
  }
  if (!std::exchange(has_protections_, true)) want_keys();
  return true;
}

// All keys of the next protection are to be exchanged, also with peers that had some before.
void GovernanceTransition::want_keys() {
  for (auto& [prefix, peer] : core_.peers)
    if (auto* association = peer.state.association()) {
      if (core_.keyring.phases().messages().has_second()) association->governance.message_keys = 0;
      association->governance.lacks_keys = true;
    }
  rematch();
}

Status GovernanceTransition::add_second_protections() {
  const auto& domain = state_.other_domain();
  if (domain && domain->rtps != core_.own->attributes().rtps) {
    const auto status = core_.keyring.phases().messages().add_second(*domain);
    if (!status) return std::unexpected(status.error().with_default_document("messages"));
  }
  auto topics = admission_.own_topics();
  if (domain) std::ranges::copy(admission_.builtin_topics(), std::back_inserter(topics));
  for (const auto& [id, topic] : topics) {
    const auto status = admission_.add_other_protection(id, topic);
    if (!status) return std::unexpected(status.error().with_default_document("topic " + topic));
  }
  return {};
}

// ---- peers without the document

void GovernanceTransition::note_all_former() {
  for (auto& [prefix, peer] : core_.peers)
    if (auto* association = peer.state.association())
      association->governance.was_associated_under_former = !has_changed(peer);
}

std::vector<GuidPrefix> GovernanceTransition::peers_of_former() {
  std::vector<GuidPrefix> out;
  for (auto& [prefix, peer] : core_.peers) {
    auto* association = peer.state.association();
    if (association == nullptr ||
        !std::exchange(association->governance.was_associated_under_former, false))
      continue;
    if (!has_changed(peer)) out.push_back(prefix);
  }
  return out;
}

void GovernanceTransition::send_again(Peer& peer) {
  auto& governance = peer.state.association()->governance;
  if (std::exchange(governance.wants_keys, false) && governance.takes_part)
    exchange_.send_again(peer);
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
  const bool is_concerned =
      state_.other_domain() ||
      core_.keyring.phases().endpoints().has_pair_under_two_protections(peer.prefix());
  if (peer.state.joined() == nullptr || !is_concerned) return true;
  return has_changed(peer) && CryptoTokenExchange::is_up_to_date(peer);
}

void GovernanceTransition::refresh(Peer& peer) const {
  auto* association = peer.state.association();
  if (association == nullptr) return;
  auto& governance = association->governance;
  governance.takes_part = has_changed(peer);
  if (state_.is_under_way() && governance.takes_part &&
      governance.received->state != State::changing)
    core_.keyring.phases().note_sends_next(peer.prefix());
}

void GovernanceTransition::report_behind() {
  each_joined([&](Peer& peer) {
    const bool is_concerned =
        state_.other_domain() ||
        core_.keyring.phases().endpoints().has_pair_under_two_protections(peer.prefix());
    if (!is_concerned || has_changed(peer)) return;
    const auto& report = peer.state.association()->governance.received;
    const bool is_ahead = report && report->version.revision > state_.target()->revision;
    core_.raise(
        Error(
            is_ahead ? Code::governance_peer_ahead : Code::governance_peer_behind,
            {.document = "governance",
             .field = "revision",
             .expected = std::to_string(state_.target()->revision),
             .found = report ? std::to_string(report->version.revision) : "an earlier one or none",
             .note = state_.other_domain()
                         ? "the session with it ends when the change is over"
                         : "its endpoints no longer match on topics that the two documents "
                           "protect differently"}),
        peer, EventOrigin::its_keys);
  });
}

void GovernanceTransition::rematch() {
  std::vector<GuidPrefix> prefixes;
  each_joined([&](Peer& peer) { prefixes.push_back(peer.prefix()); });
  for (const auto& prefix : prefixes)
    has_lost_any_ = core_.host.on_rights_changed(prefix) || has_lost_any_;
}

// ---- messages

GovernanceOfPeer::GovernanceReport GovernanceTransition::own() const {
  if (state_.is_under_way())
    return {*state_.target(),
            state_.phase() == Phase::accepting ? State::changing : State::changed};
  const auto version =
      core_.own->plugins().access_control.governance_version(core_.own->permissions());
  return {version.value_or(Version{}), State::in_force};
}

void GovernanceTransition::send_report(Peer& peer, bool wants_answer) {
  if (peer.data.vendor != kVendorDdssec || !exchange_.has_room(peer)) return;
  auto& governance = peer.state.association()->governance;
  const auto report = own();
  const bool wants_keys = state_.is_under_way() && governance.lacks_keys;
  if (governance.sent == report && !wants_keys) return;
  governance.sent = report;
  governance.lacks_keys = false;
  exchange_.send_token(peer, message_class::kGovernance,
                       token_of(report, wants_answer, wants_keys));
}

// Without a change, a peer gets a report only if it had one before or asks for one.
void GovernanceTransition::send_to_all() {
  each_joined([&](Peer& peer) {
    const auto& governance = peer.state.association()->governance;
    if (state_.is_under_way() || governance.sent) send_report(peer, !governance.sent);
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
  governance.wants_keys |= spi::find_property(token.properties, kWantsKeys) != nullptr;
  if (governance.wants_keys && governance.repetitions.try_spend(core_.now)) send_again(peer);
  // Until there are keys for the second protection, the peer must not send its own.
  if (state_.phase() == Phase::accepting && !has_protections_) return;
  if (spi::find_property(token.properties, kWantsAnswer) != nullptr &&
      governance.answers.try_spend(core_.now)) {
    governance.sent.reset();
    send_report(peer, false);
  }
  if (!took_part && governance.takes_part) exchange_.complete_pairs(peer);
}

}  // namespace ddssec::rtps
