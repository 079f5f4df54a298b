#include "rtps/security/memory_exchange.hpp"

#include <algorithm>

namespace ddssec::rtps {

memory::Outcome<std::unique_ptr<MemoryExchange>> MemoryExchange::make(
    SecurityCore& core, KeyExchange& exchange, const spi::SharedMemory& settings) {
  SystemRandom random;
  auto server = memory::DescriptorServer::listen(random);
  if (!server) return memory::refuse(server.error());
  auto readiness = memory::Readiness::make();
  if (!readiness) return memory::refuse(readiness.error());
  if (!readiness->add(server->descriptor())) return memory::refuse(memory::Refusal::no_socket);
  return std::unique_ptr<MemoryExchange>(
      new MemoryExchange(core, exchange, settings, *std::move(server), *std::move(readiness)));
}

MemoryExchange::MemoryExchange(SecurityCore& core, KeyExchange& exchange,
                               const spi::SharedMemory& settings, memory::DescriptorServer server,
                               memory::Readiness readiness)
    : core_{core, exchange, settings, std::move(server)},
      readiness_(std::move(readiness)),
      mapped_(readiness_,
              [this](const GuidPrefix& to, const MemoryAnswer& it) { answer(to, it); }) {
  exchange.on_memory([this](Peer& peer, const GenericMessage& message) {
    if (message.data.size() == 1 && peer.state.joined() != nullptr)
      on_message(peer, message.data[0]);
  });
}

void MemoryExchange::serve(MonotonicTime now) {
  core_.security.now = now;
  core_.server.serve(now);
  mapped_.serve(now);
}

MonotonicTime MemoryExchange::next_tick() const {
  return std::min(core_.server.deadline().value_or(kNever), mapped_.next_tick());
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
  const auto offer = offer_in(token);
  if (offer && is_barred(peer))
    return answer(peer.prefix(),
                  {offer->writer, offer->offer.segment, memory::Refusal::wrong_kind});
  if (offer) return mapped_.on_offer(peer.prefix(), *offer, core_.security.now);
  const auto answer = answer_in(token);
  if (!answer) return;
  const auto at = writers_.find(answer->writer);
  if (at != writers_.end()) at->second.memory->on_answer(peer.prefix(), *answer);
}

bool MemoryExchange::is_barred(const Peer& peer) const {
  const auto identity = core_.security.proven_subject(peer);
  return !identity || barred_.contains(*identity) || barred_.size() >= kMostBarred;
}

// A peer that does not acknowledge is not answered: its offer ends by itself.
void MemoryExchange::answer(const GuidPrefix& to, const MemoryAnswer& answer) {
  auto* const peer = core_.security.find(to);
  // No honest process passes a descriptor of another kind, and each may stay open for ever.
  if (peer != nullptr && answer.refusal == memory::Refusal::wrong_kind && !is_barred(*peer))
    barred_.insert(*core_.security.proven_subject(*peer));
  if (peer == nullptr || peer->state.joined() == nullptr || !core_.exchange.has_room(*peer)) return;
  core_.exchange.send_token(*peer, message_class::kMemory, token_of(answer));
  if (answer.refusal && *answer.refusal != memory::Refusal::not_matched &&
      *answer.refusal != memory::Refusal::other_segment)
    core_.report(to, memory::to_string(*answer.refusal));
}

}  // namespace ddssec::rtps
