#include "rtps/reliability/past_writers.hpp"

#include <algorithm>

namespace ddssec::rtps {

template <class F>
void PastWriters::each_of(const GuidPrefix& participant, F&& f) {
  for (auto at = writers_.lower_bound({participant, {}}); at != writers_.end(); ++at) {
    if (at->first.prefix != participant) return;
    f(at->first, at->second.position);
  }
}

void PastWriters::add(const Guid& writer, const GuidPrefix& identity, const Position& position) {
  static_cast<void>(take(writer));
  writers_[writer] = {position, identity, ++last_};
  of_[identity][last_] = writer;
  if (writers_.size() <= kMax) return;
  const auto most =
      std::ranges::max_element(of_, {}, [](const auto& of_one) { return of_one.second.size(); });
  static_cast<void>(take(Guid(most->second.begin()->second)));
}

void PastWriters::note_revised(const Guid& writer, const KeysOf& keys_of) {
  each_of(writer.prefix, [&](const Guid& guid, Position& position) {
    if (!writer.entity.is_zero() && guid != writer) return;
    position.newest_next = {1};
    position.newest_heartbeat.reset();
    if (const auto keys = keys_of(guid)) position.keys = *keys;
  });
}

void PastWriters::distrust_former_keys(const GuidPrefix& participant) {
  each_of(participant, [](const Guid&, Position& position) { position.is_doubted = true; });
}

std::optional<PastWriters::Position> PastWriters::take(const Guid& writer) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return std::nullopt;
  const auto [position, identity, number] = at->second;
  writers_.erase(at);
  const auto share = of_.find(identity);
  share->second.erase(number);
  if (share->second.empty()) of_.erase(share);
  return position;
}

}  // namespace ddssec::rtps
