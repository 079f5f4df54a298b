// The memory of one local writer, and which participants read it.
#pragma once

#include <map>
#include <set>

#include "rtps/budget/work_budget.hpp"
#include "rtps/memory/descriptor_passing.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "rtps/security/crypto_token_exchange.hpp"
#include "rtps/security/kept_memory.hpp"
#include "rtps/security/memory_messages.hpp"

namespace ddssec::rtps {

/// What the memory of all writers of a participant has in common.
struct MemoryCore {
  SecurityCore& security;
  CryptoTokenExchange& exchange;
  spi::SharedMemory settings = {};
  std::unique_ptr<memory::DescriptorPassing> passing;
  SystemRandom random = {};
  std::size_t octets = 0;  ///< of all segments that writers use, or wait for
  KeptMemory kept = {};
  /// What passing prepares, others have, and no writer waits for any longer.
  std::set<std::uint64_t> orphans = {};
  std::set<GuidPrefix> reported = {};  ///< peers of which an event said why memory is not used

  /// Raises an event, once for each peer.
  void report(const GuidPrefix& peer, std::string_view why);
};

/// A participant reads the memory once it has mapped it, which it is offered when a sample is
/// written that is large enough. When it has no matched reader any longer, the memory is given up:
/// the others get another one, in which the participant sees nothing (KeptMemory). No clock or
/// lock.
class WrittenMemory final : public SampleMemory {
 public:
  /// What payload protection adds at most, in octets.
  static constexpr std::size_t kProtectionRoom = 64;
  /// Samples with smaller or larger payloads are sent in messages; in octets.
  static constexpr std::size_t kMin = std::size_t{8} << 10;
  static constexpr std::size_t kMax = (std::size_t{16} << 20) - kProtectionRoom;
  /// How long a participant that refuses is not asked again: at first, and at most.
  static constexpr MonotonicTime kPause = std::chrono::seconds(1);
  static constexpr MonotonicTime kMaxPause = std::chrono::minutes(1);
  /// After so many refusals that may pass by, an event says so.
  static constexpr int kReportedTries = 3;

  /// Both must outlive this object.
  WrittenMemory(MemoryCore& core, StatefulWriter& writer) : core_(core), writer_(writer) {}
  /// The writer may have been destroyed by then, with all of the participant.
  ~WrittenMemory() override;
  /// The writer is removed, and still there.
  void end();

  void add_reader(const Guid& reader);
  void remove_reader(const Guid& reader);
  void on_answer(const GuidPrefix& from, const MemoryAnswer& answer);
  /// What this writer waits for was made.
  bool waits_for(std::uint64_t id) const { return awaited_ && awaited_->id == id; }
  void on_prepared(memory::MemoryResult<memory::SampleSlots> slots, MonotonicTime now);

  std::optional<MemoryReference> store(const Change& change, SequenceNumber needed_from,
                                       MonotonicTime now) override;

 private:
  using Form = MemoryForm;
  /// A participant with matched readers.
  struct Reading {
    enum class State : std::uint8_t { waiting, offered, mapped };
    std::set<EntityId> readers = {};
    State state = State::waiting;
    int tries = 0;
    MonotonicTime next = {};    ///< when it is offered the memory, or has not answered
    bool is_used = false;       ///< an event said that it reads the memory
    std::string identity = {};  ///< proven, since it was offered memory
  };
  /// A segment that is being made, or wiped: then others have it.
  struct Awaited {
    std::uint64_t id = 0;
    std::size_t largest = 0, octets = 0;
    Form form = Form::none;
    KeptMemory::Holders holders = {};
    std::string leaver = {};  ///< the identity for which it counts if it is kept again
  };

  const EntityId& id() const { return writer_.guid().entity; }
  /// How payloads may stand in memory, as the governance demands.
  Form form() const;
  void report_all(std::string_view why);
  /// Returns false if the payload cannot go through memory.
  bool prepare(std::size_t payload_size, MonotonicTime now);
  /// Asks for a segment for payloads of up to `largest` octets.
  memory::MemoryResult<void> request_segment(std::size_t largest);
  /// Uses a former segment again if all that may have it may read, and more than have this one.
  bool reuse(std::size_t needed);
  bool may_all_read(const KeptMemory::Holders& holders) const;
  /// `leaver`: see KeptMemory.
  void give_up(std::string leaver = {});
  void stop_waiting();
  void offer_to_all(MonotonicTime now);
  void offer(const GuidPrefix& prefix, Reading& reading, MonotonicTime now);
  void note_refusal(const GuidPrefix& prefix, Reading& reading, memory::MemoryRefusal why,
                    MonotonicTime now);
  void set_mapped(const GuidPrefix& prefix, Reading& reading);
  void set_waiting(const GuidPrefix& prefix, Reading& reading);
  std::optional<MemoryReference> put(const Change& change, SequenceNumber needed_from,
                                     MonotonicTime now);

  MemoryCore& core_;
  StatefulWriter& writer_;
  std::map<GuidPrefix, Reading> readings_;
  std::size_t mapped_ = 0;  ///< how many of them have mapped it
  std::optional<Awaited> awaited_;
  std::optional<memory::SampleSlots> slots_;
  /// Were offered this segment, and may have mapped it whatever they answer.
  KeptMemory::Holders holders_;
  bool may_reuse_ = false;           ///< a participant came since reuse() was tried
  std::size_t largest_ = 0;          ///< payload of any segment until now
  Form form_ = Form::none;           ///< of what is in the slots
  MonotonicTime next_segment_ = {};  ///< after one could not be made
  /// A peer whose readers come and go costs a segment each time.
  WorkBudget segments_{16, std::chrono::seconds(1), {}};
};

}  // namespace ddssec::rtps
