#include "rtps/security/dormant_peers.hpp"

#include <algorithm>

#include "rtps/budget/subject_shares.hpp"

namespace ddssec::rtps {

// While keys are revised or the governance changes, a peer that is not heard gets nothing new.
bool DormantPeers::can_keep(const GuidPrefix& prefix) const {
  const auto* peer = core_.find(prefix);
  if (peer == nullptr || !CryptoTokenExchange::is_trusted(*peer)) return false;
  return peer->data.vendor != kVendorDdssec && !peer->state.association()->reset &&
         !key_reviser_.is_busy() && !core_.governance_change.is_under_way();
}

void DormantPeers::keep(const GuidPrefix& prefix) {
  auto node = core_.peers.extract(prefix);
  // A peer chooses its lease. A pause even before the first query limits how often it comes and
  // goes, which costs us more than the peer.
  DormantPeer dormant{
      .peer = std::move(node.mapped()), .since = core_.now, .next_query = core_.now + kQueryPeriod};
  dormant.peer.state.association()->place = {};
  send_to(dormant, {});
  core_.dormant.insert_or_assign(prefix, std::move(dormant));
  make_room();
}

void DormantPeers::make_room() {
  while (core_.dormant.size() > kMaxPeers) {
    std::map<SubjectShares::Subject, std::size_t> of_subject;
    for (const auto& [prefix, dormant] : core_.dormant)
      ++of_subject[SubjectShares::subject_of(prefix)];
    const auto largest =
        std::ranges::max_element(of_subject, {}, [](const auto& one) { return one.second; });
    const DormantPeer* oldest = nullptr;
    for (const auto& [prefix, dormant] : core_.dormant)
      if (SubjectShares::subject_of(prefix) == largest->first &&
          (oldest == nullptr || dormant.since < oldest->since))
        oldest = &dormant;
    drop(GuidPrefix(oldest->peer.prefix()));
  }
}

void DormantPeers::send_to(DormantPeer& dormant, const LocatorList& addresses) {
  const auto& association = *dormant.peer.state.association();
  const auto& prefix = dormant.peer.prefix();
  association.volatile_writer->readdress({prefix, kVolatileMessageReader}, addresses, core_.now);
  association.volatile_reader->readdress({prefix, kVolatileMessageWriter}, addresses);
}

// The first query is a new message. The peer's acknowledgment of it cannot have been recorded
// before. Everything else that arrives can be, or can be forged.
void DormantPeers::note_heard(const GuidPrefix& prefix, MonotonicTime now) {
  core_.set_now(now);
  const auto at = core_.dormant.find(prefix);
  if (at == core_.dormant.end() || core_.now < at->second.next_query) return;
  auto& dormant = at->second;
  dormant.next_query = core_.now + kQueryPeriod;
  dormant.quiet_at = core_.now + kAnswerTime;
  send_to(dormant, dormant.peer.metatraffic);
  if (std::exchange(dormant.is_asked, true))
    exchange_.ask_for_sign_of_life(dormant.peer);
  else
    exchange_.ask(dormant.peer);
}

void DormantPeers::note_acknowledged(const GuidPrefix& prefix) {
  const auto at = core_.dormant.find(prefix);
  if (at == core_.dormant.end()) return;
  const auto& dormant = at->second;
  if (dormant.is_asked && dormant.peer.state.association()->volatile_writer->all_acknowledged())
    answered_.push_back(prefix);
}

std::optional<Peer> DormantPeers::take(const GuidPrefix& prefix) {
  const auto at = core_.dormant.find(prefix);
  if (at == core_.dormant.end()) return std::nullopt;
  send_to(at->second, at->second.peer.metatraffic);
  std::optional out = std::move(at->second.peer);
  core_.dormant.erase(at);
  return out;
}

void DormantPeers::drop(const GuidPrefix& prefix) {
  const auto at = core_.dormant.find(prefix);
  if (at == core_.dormant.end()) return;
  key_reviser_.note_absent(at->second.peer);
  core_.dormant.erase(at);
}

void DormantPeers::distrust(const GuidPrefix& prefix) {
  if (core_.dormant.erase(prefix) > 0) key_reviser_.request();
}

std::vector<GuidPrefix> DormantPeers::prefixes() const {
  std::vector<GuidPrefix> out;
  for (const auto& [prefix, dormant] : core_.dormant) out.push_back(prefix);
  return out;
}

void DormantPeers::drop_all() {
  for (const auto& prefix : prefixes()) drop(prefix);
}

void DormantPeers::tick() {
  if (core_.governance_change.is_under_way()) return drop_all();
  for (const auto& prefix : prefixes()) {
    auto& dormant = core_.dormant.at(prefix);
    if (core_.now >= dormant.since + kLife) {
      drop(prefix);
    } else if (core_.now >= dormant.quiet_at) {
      dormant.quiet_at = kNever;
      send_to(dormant, {});
    }
  }
}

}  // namespace ddssec::rtps
