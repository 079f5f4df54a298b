#include "rtps/security/written_memory.hpp"

#include <algorithm>
#include <bit>

namespace ddssec::rtps {
namespace {

// The pause before another try at something that other participants must free first.
constexpr MonotonicTime kLongPause = std::chrono::seconds(10);

}  // namespace

void MemoryCore::report(const GuidPrefix& peer, std::string_view why) {
  constexpr std::size_t kMaxReported = 1024;
  if (reported.size() >= kMaxReported) reported.clear();
  if (!reported.insert(peer).second) return;
  security.raise(Error(Code::rtps_memory_unused, {.document = "shared memory",
                                                  .found = std::string(why),
                                                  .note = "no further event about this peer "
                                                          "follows"}),
                 Guid{peer, kEntityIdParticipant}, EventOrigin::its_keys);
}

WrittenMemory::~WrittenMemory() {
  stop_waiting();
  if (!slots_) return;
  core_.passing->offers().withdraw(slots_->segment().id());
  core_.octets -= slots_->segment().octets();
}

void WrittenMemory::end() {
  give_up();
  core_.kept.remove_writer(id());
}

// If others may have the memory, MemoryExchange keeps it once it is prepared (orphans).
void WrittenMemory::stop_waiting() {
  if (!awaited_) return;
  core_.octets -= awaited_->octets;
  if (!awaited_->holders.empty()) core_.orphans.insert(awaited_->id);
  awaited_.reset();
}

// ---- readers

void WrittenMemory::add_reader(const Guid& reader) {
  auto& reading = readings_[reader.prefix];
  may_reuse_ |= reading.readers.empty();
  reading.readers.insert(reader.entity);
  if (reading.state == ReadingParticipant::State::mapped)
    writer_.memory().set_reading(reader.prefix, true);
}

void WrittenMemory::remove_reader(const Guid& reader) {
  const auto at = readings_.find(reader.prefix);
  if (at == readings_.end()) return;
  at->second.readers.erase(reader.entity);
  if (!at->second.readers.empty()) return;
  const auto leaver = std::move(at->second.identity);
  if (at->second.state == ReadingParticipant::State::mapped) set_waiting(reader.prefix, at->second);
  readings_.erase(at);
  if (holders_.contains(reader.prefix)) give_up(leaver);
}

void WrittenMemory::set_mapped(const GuidPrefix& prefix, ReadingParticipant& reading) {
  reading.state = ReadingParticipant::State::mapped;
  reading.tries = 0;
  ++mapped_;
  writer_.memory().set_reading(prefix, true);
  if (std::exchange(reading.is_used, true)) return;
  core_.security.raise(
      Error(Code::rtps_memory_used, {.document = "writer " + id().to_string(),
                                     .note = "payloads from " + std::to_string(kMin) + " to " +
                                             std::to_string(kMax) + " octets"}),
      Guid{prefix, kEntityIdParticipant}, EventOrigin::its_keys);
}

void WrittenMemory::set_waiting(const GuidPrefix& prefix, ReadingParticipant& reading) {
  if (reading.state == ReadingParticipant::State::mapped) {
    --mapped_;
    writer_.memory().set_reading(prefix, false);
  }
  reading.state = ReadingParticipant::State::waiting;
}

void WrittenMemory::note_refusal(const GuidPrefix& prefix, ReadingParticipant& reading,
                                 memory::MemoryRefusal why, MonotonicTime now) {
  set_waiting(prefix, reading);
  reading.next = now + std::min(kPause * (1 << reading.tries), kMaxPause);
  reading.tries = std::min(reading.tries + 1, 6);
  if (!memory::may_pass_by(why) || reading.tries == kReportedTries)
    core_.report(prefix, memory::to_string(why));
}

void WrittenMemory::on_answer(const GuidPrefix& from, const MemoryAnswer& answer) {
  const auto at = readings_.find(from);
  if (at == readings_.end() || !slots_ || slots_->segment().id() != answer.segment) return;
  auto& reading = at->second;
  if (reading.state == ReadingParticipant::State::waiting) return;
  if (answer.refusal) return note_refusal(from, reading, *answer.refusal, core_.security.now);
  if (reading.state == ReadingParticipant::State::offered) set_mapped(from, reading);
}

// ---- segments

WrittenMemory::Form WrittenMemory::form() const {
  const auto* attributes = core_.security.keyring.attributes(id());
  if (attributes == nullptr) return Form::none;
  const auto form = !attributes->is_payload_protected()      ? Form::plain
                    : spi::is_encrypted(attributes->payload) ? Form::encrypted
                                                             : Form::authenticated;
  if (spi::is_encrypted(attributes->payload) || core_.settings.trusts_kernel) return form;
  const auto& participant = core_.security.own->attributes();
  const auto of_messages =
      participant.is_rtps_protected() ? participant.rtps : participant.rtps_psk;
  const bool hides = spi::is_encrypted(attributes->submessage) || spi::is_encrypted(of_messages);
  return hides ? Form::none : form;
}

void WrittenMemory::report_all(std::string_view why) {
  for (const auto& [prefix, reading] : readings_) core_.report(prefix, why);
}

// Memory that a participant has mapped stays as it is: nothing is written there until reuse().
void WrittenMemory::give_up(std::string leaver) {
  if (!slots_) return;
  core_.passing->offers().withdraw(slots_->segment().id());
  core_.octets -= slots_->segment().octets();
  if (!holders_.empty())
    core_.kept.keep(id(), {*std::move(slots_), form_, std::move(holders_)}, std::move(leaver));
  slots_.reset();
  holders_.clear();
  may_reuse_ = true;
  for (auto& [prefix, reading] : readings_) {
    set_waiting(prefix, reading);
    reading.next = {};
  }
}

bool WrittenMemory::may_all_read(const KeptMemory::Holders& holders) const {
  return std::ranges::all_of(holders, [&](const auto& one) { return readings_.contains(one); });
}

// The former segment is wiped first, because participants that come later may not see its content.
bool WrittenMemory::reuse(std::size_t needed) {
  if (!may_reuse_ || !core_.passing->accepts_work()) return false;
  may_reuse_ = false;
  core_.kept.forget_returned();
  auto former = core_.kept.take(id(), form_, needed, holders_.size(),
                                [&](const auto& prefix) { return readings_.contains(prefix); });
  if (!former) return false;
  const auto& segment = former->slots.segment();
  const auto largest = segment.largest_payload(), octets = segment.octets();
  core_.octets += octets;
  awaited_ = {core_.passing->wipe(std::move(former->slots)),
              largest,
              octets,
              form_,
              std::move(former->holders),
              std::move(former->leaver)};
  return true;
}

bool WrittenMemory::prepare(std::size_t payload_size, MonotonicTime now) {
  const auto wanted = form();
  if (wanted != form_) {
    give_up();
    core_.kept.remove_writer(id());  // not used again in the former form
  }
  form_ = wanted;
  if (wanted == Form::none) {
    report_all(
        "the governance encrypts messages or submessages but not data, and payloads may not stand "
        "in memory unencrypted without the property org.ddssec.shm.trust_kernel");
    return false;
  }
  const auto needed = payload_size + kProtectionRoom;
  const bool fits = slots_ && slots_->segment().largest_payload() >= needed;
  if (awaited_ || reuse(needed) || fits) return fits;
  if (now < next_segment_ || !segments_.try_spend(now)) return false;
  // The size is doubled, so that growing samples need few segments.
  const auto largest = needed <= largest_
                           ? largest_
                           : std::max(needed, std::min(2 * largest_, kMax + kProtectionRoom));
  if (const auto asked = request_segment(largest); !asked) {
    // Smaller samples still go through the present segment.
    next_segment_ = now + kLongPause;
    report_all(memory::to_string(asked.error()));
  }
  return false;
}

memory::MemoryResult<void> WrittenMemory::request_segment(std::size_t largest) {
  std::array<std::uint8_t, sizeof(std::uint64_t)> octets{};
  const auto size = memory::SampleSlots::size_for(largest);
  core_.kept.forget_returned();
  if (core_.octets + core_.kept.octets() + size > core_.settings.max_octets)
    return memory::refuse(memory::MemoryRefusal::limit_reached);
  if (!core_.random.fill(octets)) return memory::refuse(memory::MemoryRefusal::no_memory);
  const auto asked = core_.passing->make_slots(std::bit_cast<std::uint64_t>(octets), largest);
  if (!asked) return memory::refuse(asked.error());
  core_.octets += size;
  awaited_ = {*asked, largest, size, form_, {}};
  return {};
}

void WrittenMemory::on_prepared(memory::MemoryResult<memory::SampleSlots> slots,
                                MonotonicTime now) {
  auto awaited = *std::exchange(awaited_, std::nullopt);
  core_.octets -= awaited.octets;
  if (!slots) {
    next_segment_ = now + kLongPause;
    return report_all(memory::to_string(slots.error()));
  }
  if (awaited.form != form_ || !may_all_read(awaited.holders)) {
    if (!awaited.holders.empty())
      core_.kept.keep(id(), {*std::move(slots), awaited.form, std::move(awaited.holders)},
                      std::move(awaited.leaver));
    may_reuse_ = true;
    return;
  }
  give_up();
  may_reuse_ = false;
  largest_ = std::max(largest_, awaited.largest);
  slots_.emplace(*std::move(slots));
  holders_ = std::move(awaited.holders);
  core_.octets += slots_->segment().octets();
}

void WrittenMemory::offer_to_all(MonotonicTime now) {
  if (mapped_ == readings_.size()) return;
  for (auto& [prefix, reading] : readings_) {
    if (reading.state == ReadingParticipant::State::mapped || now < reading.next) continue;
    if (reading.state == ReadingParticipant::State::offered)
      note_refusal(prefix, reading, memory::MemoryRefusal::no_answer, now);
    else
      offer(prefix, reading, now);
  }
}

void WrittenMemory::offer(const GuidPrefix& prefix, ReadingParticipant& reading,
                          MonotonicTime now) {
  auto* const peer = core_.security.find(prefix);
  reading.next = now + kPause;
  if (peer == nullptr || peer->state.joined() == nullptr || !core_.exchange.has_room(*peer)) return;
  auto identity = core_.security.proven_subject(*peer);
  if (!identity) return;
  reading.identity = *std::move(identity);
  if (!holders_.contains(prefix) && core_.kept.is_full(reading.identity)) {
    core_.kept.forget_returned();
    reading.next = now + kLongPause;
    return core_.report(prefix,
                        "participants of its identity may still have too much memory of "
                        "this participant, of matches that ended");
  }
  auto made = core_.passing->offer(slots_->segment(), core_.random, now, reading.identity);
  if (!made) return note_refusal(prefix, reading, made.error(), now);
  reading.state = ReadingParticipant::State::offered;
  holders_.insert(prefix);
  reading.next = now + memory::OpenOffers::kLifetime;
  core_.exchange.send_token(*peer, message_class::kMemory,
                            token_of(MemoryOffer{id(), *std::move(made)}));
}

// ---- samples

std::optional<MemoryReference> WrittenMemory::store(const Change& change,
                                                    SequenceNumber needed_from, MonotonicTime now) {
  const auto size = change.payload.size();
  if (readings_.empty() || size < kMin || size > kMax || !change.is_alive()) return std::nullopt;
  if (!prepare(size, now)) return std::nullopt;
  offer_to_all(now);
  return mapped_ == 0 ? std::nullopt : put(change, needed_from, now);
}

// A burst may find all slots in use for a moment, so only a series of samples is reported.
void WrittenMemory::note_full(MonotonicTime now) {
  full_ = std::min(full_ + 1, kReportedFull);
  if (full_ < kReportedFull || !core_.full_events.try_spend(now)) return;
  core_.security.events.raise(Event(
      Error(Code::rtps_memory_unused,
            {.document = "shared memory of writer " + id().to_string(),
             .found = std::string(memory::to_string(memory::MemoryRefusal::full)),
             .note = "a reliable reader counts until it has not acknowledged for half a second; "
                     "there is at most one such event a minute"})));
}

std::optional<MemoryReference> WrittenMemory::put(const Change& change, SequenceNumber needed_from,
                                                  MonotonicTime now) {
  const auto place = slots_->begin(needed_from, now);
  if (!place) {
    note_full(now);
    return std::nullopt;
  }
  full_ = 0;
  const auto payload = change.payload.view();
  auto size = payload.size();
  if (form_ != Form::plain) {
    const auto encoded = core_.security.keyring.protect_payload(id(), payload, *place);
    if (!encoded) {
      slots_->cancel();
      return std::nullopt;
    }
    size = *encoded;
  } else {
    std::ranges::copy(payload, place->begin());
  }
  return slots_->end(change.sequence_number, size, now);
}

}  // namespace ddssec::rtps
