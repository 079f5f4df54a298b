#include "tests/sim/ambush.hpp"

#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps::sim {
namespace {

constexpr std::size_t kPrefixAt = 8;

bool is_by(BytesView datagram, const GuidPrefix& whose) {
  return datagram.size() >= kHeaderSize &&
         std::ranges::equal(datagram.subspan(kPrefixAt, GuidPrefix::size), whose.view());
}

}  // namespace

std::vector<GuidPrefix> Ambush::young(MonotonicTime now) const {
  std::vector<GuidPrefix> out;
  for (const auto& [prefix, life] : ledger_.lives())
    if (life.died == kNever && life.subject->role == Role::honest && now - life.born < kYouth)
      out.push_back(prefix);
  return out;
}

Bytes Ambush::operator()(MonotonicTime now) {
  const auto victims = young(now);
  if (victims.empty()) return {};
  const auto& victim = dice_.of(victims);
  return dice_.chance(500) ? endpoints_of(victim) : addresses_of(victim);
}

// Returns announcements of the victim's endpoints under the first sequence numbers, because its
// readers expect those.
Bytes Ambush::endpoints_of(const GuidPrefix& victim) {
  auto out = testing::forged(victim);
  std::int64_t publications = 0, subscriptions = 0;
  const auto& ends = invariants_.ends();
  for (auto at = ends.lower_bound({victim, {}}); at != ends.end() && at->first.prefix == victim;
       ++at) {
    const auto& [guid, end] = *at;
    EndpointData data{.guid = guid, .topic_name = std::string(end.topic), .type_name = "ShapeType"};
    data.qos = end.writes ? default_writer_qos() : default_reader_qos();
    Bytes buffer(4096);
    SpanWriter payload(buffer);
    write_payload(payload, data);
    const auto datagram =
        testing::forged(victim, Data{kEntityIdUnknown,
                                     end.writes ? kPublicationsWriter : kSubscriptionsWriter,
                                     {end.writes ? ++publications : ++subscriptions},
                                     {},
                                     PayloadKind::data,
                                     payload.view()});
    out.insert(out.end(), datagram.begin() + kHeaderSize, datagram.end());
  }
  return out;
}

Bytes Ambush::addresses_of(const GuidPrefix& victim) {
  for (const auto& datagram : recorded_) {
    if (!is_by(datagram.octets, victim)) continue;
    auto data = testing::announced_in(datagram.octets);
    if (!data) continue;
    data->metatraffic_unicast.assign(1, Locator::udp_v4({192, 0, 2, dice_.octet()}, 7400));
    data->default_unicast = data->metatraffic_unicast;
    return testing::announcement(*data);
  }
  return {};
}

}  // namespace ddssec::rtps::sim
