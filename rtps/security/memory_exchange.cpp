#include "rtps/security/memory_exchange.hpp"

#include <algorithm>

namespace ddssec::rtps {

memory::MemoryResult<std::unique_ptr<MemoryExchange>> MemoryExchange::make(
    SecurityCore& core, CryptoTokenExchange& exchange, const spi::SharedMemory& settings) {
  SystemRandom random;
  const auto users = settings.with_other_users ? memory::Users::any : memory::Users::own;
  auto passing = memory::DescriptorPassing::make(random, users);
  if (!passing) return memory::refuse(passing.error());
  return std::unique_ptr<MemoryExchange>(
      new MemoryExchange(core, exchange, settings, *std::move(passing)));
}

MemoryExchange::MemoryExchange(SecurityCore& core, CryptoTokenExchange& exchange,
                               const spi::SharedMemory& settings,
                               std::unique_ptr<memory::DescriptorPassing> passing)
    : core_{core, exchange, settings, std::move(passing)},
      mapped_(
          *core_.passing, [this](const GuidPrefix& to, const MemoryAnswer& it) { answer(to, it); },
          [this](const GuidPrefix& prefix) {
            const auto* const peer = core_.security.find(prefix);
            return peer == nullptr ? std::string()
                                   : core_.security.proven_subject(*peer).value_or(std::string());
          },
          [this](const GuidPrefix& from) {
            core_.report(from,
                         "the writer's participant offers no memory: the property org.ddssec.shm "
                         "is off there, or event 1792 of that participant says why");
          }) {
  exchange.listen({message_class::kMemory}, [this](Peer& peer, const GenericMessage& message) {
    if (message.data.size() == 1 && peer.state.joined() != nullptr)
      on_message(peer, message.data[0]);
  });
}

void MemoryExchange::start() {
  if (core_.passing->start()) return;
  core_.security.events.raise(
      Event(Error(Code::rtps_memory_unused,
                  {.document = "shared memory", .found = "the system gave no thread"})));
}

void MemoryExchange::serve(MonotonicTime now) {
  core_.security.set_now(now);
  core_.passing->serve(now);
  adopt_prepared(now);
  mapped_.serve(now);
  poll_kept_memory(now);
}

// Memory that was wiped for further use, but that no writer wants by now, is still mapped by
// others, so it is kept.
void MemoryExchange::adopt_prepared(MonotonicTime now) {
  for (auto& [id, slots] : core_.passing->take_prepared()) {
    const auto at = std::ranges::find_if(
        writers_, [&](const auto& entry) { return entry.second.memory->waits_for(id); });
    if (at != writers_.end())
      at->second.memory->on_prepared(std::move(slots), now);
    else if (core_.orphans.erase(id) > 0 && slots)
      core_.kept.keep_retired({*std::move(slots)});
  }
}

void MemoryExchange::poll_kept_memory(MonotonicTime now) {
  constexpr MonotonicTime kPause = std::chrono::seconds(1);
  if (core_.kept.segments() == 0) {
    next_look_ = kNever;
  } else if (next_look_ == kNever) {
    next_look_ = now + kPause;
  } else if (now >= next_look_) {
    core_.kept.forget_returned();
    next_look_ = now + kPause;
  }
}

MonotonicTime MemoryExchange::next_tick() const {
  return std::min({core_.passing->deadline().value_or(kNever), mapped_.next_tick(), next_look_});
}

void MemoryExchange::add_reader(StatefulWriter& writer, const Guid& reader) {
  auto at = writers_.find(writer.guid().entity);
  if (at == writers_.end()) {
    auto memory = std::make_unique<WrittenMemory>(core_, writer);
    writer.memory().use(memory.get());
    at = writers_.try_emplace(writer.guid().entity, writer, std::move(memory)).first;
  }
  at->second.memory->add_reader(reader);
}

void MemoryExchange::remove_reader(const EntityId& writer, const Guid& reader) {
  const auto at = writers_.find(writer);
  if (at != writers_.end()) at->second.memory->remove_reader(reader);
}

void MemoryExchange::remove_writer(const EntityId& writer) {
  const auto at = writers_.find(writer);
  if (at == writers_.end()) return;
  at->second.writer.memory().use(nullptr);
  at->second.memory->end();
  writers_.erase(at);
}

void MemoryExchange::on_message(Peer& peer, const spi::Token& token) {
  auto offer = offer_in(token);
  if (offer && is_barred(peer))
    return answer(peer.prefix(),
                  {offer->writer, offer->offer.segment, memory::MemoryRefusal::wrong_kind});
  if (offer) return mapped_.on_offer(peer.prefix(), *std::move(offer), core_.security.now);
  const auto answer = answer_in(token);
  if (!answer) return;
  const auto at = writers_.find(answer->writer);
  if (at != writers_.end()) at->second.memory->on_answer(peer.prefix(), *answer);
}

bool MemoryExchange::is_barred(const Peer& peer) const {
  const auto identity = core_.security.proven_subject(peer);
  return !identity || barred_.contains(*identity) || barred_.size() >= kMaxBarred;
}

// A peer that does not acknowledge is not answered: its offer ends by itself.
void MemoryExchange::answer(const GuidPrefix& to, const MemoryAnswer& answer) {
  auto* const peer = core_.security.find(to);
  // No honest process passes a descriptor of another kind, and each may stay open for ever.
  if (peer != nullptr && answer.refusal == memory::MemoryRefusal::wrong_kind && !is_barred(*peer))
    barred_.insert(*core_.security.proven_subject(*peer));
  if (peer == nullptr || peer->state.joined() == nullptr || !core_.exchange.has_room(*peer)) return;
  core_.exchange.send_token(*peer, message_class::kMemory, token_of(answer));
  if (answer.refusal && !memory::may_pass_by(*answer.refusal))
    core_.report(to, memory::to_string(*answer.refusal));
}

void decline_memory(CryptoTokenExchange& exchange, Peer& peer, const GenericMessage& message) {
  if (message.data.size() != 1 || peer.state.joined() == nullptr || !exchange.has_room(peer))
    return;
  if (const auto offer = offer_in(message.data[0]))
    exchange.send_token(
        peer, message_class::kMemory,
        token_of(MemoryAnswer{offer->writer, offer->offer.segment, memory::MemoryRefusal::off}));
}

}  // namespace ddssec::rtps
