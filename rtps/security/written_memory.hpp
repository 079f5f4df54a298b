// The memory of one local writer, and the participants that read it.
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

/// The state that the memory of all writers of a participant shares.
struct MemoryCore {
  SecurityCore& security;
  CryptoTokenExchange& exchange;
  spi::SharedMemory settings = {};
  std::unique_ptr<memory::DescriptorPassing> passing;
  SystemRandom random = {};
  std::size_t octets = 0;  ///< of all segments that writers use, or wait for
  KeptMemory kept = {};
  /// Segments that are being prepared, that others have, and for which no writer waits any longer.
  std::set<std::uint64_t> orphans = {};
  std::set<GuidPrefix> reported = {};  ///< peers about which an event told why memory is not used
  WorkBudget full_events{1, std::chrono::minutes(1), {}};  ///< events about full memory

  /// Raises an event, once for each peer.
  void report(const GuidPrefix& peer, std::string_view why);
};

/// Memory of one writer. A participant reads it once it has mapped it; it is offered the memory
/// when a large enough sample is written. When the participant has no matched reader any longer,
/// the memory is given up: the others get another one, in which the participant sees nothing
/// (KeptMemory). No clock or lock.
class WrittenMemory final : public SampleMemory {
 public:
  /// The largest number of octets that payload protection adds.
  static constexpr std::size_t kProtectionRoom = 64;
  /// Samples with smaller or larger payloads are sent in messages; in octets.
  static constexpr std::size_t kMin = std::size_t{8} << 10;
  static constexpr std::size_t kMax = (std::size_t{16} << 20) - kProtectionRoom;
  /// The first and the longest time for which a participant that refuses is not asked again.
  static constexpr MonotonicTime kPause = std::chrono::seconds(1);
  static constexpr MonotonicTime kMaxPause = std::chrono::minutes(1);
  /// The number of refusals that may pass by after which an event reports them.
  static constexpr int kReportedTries = 3;
  /// The number of samples in a row without a free slot after which an event reports it.
  static constexpr int kReportedFull = 16;

  /// Both must outlive this object.
  WrittenMemory(MemoryCore& core, StatefulWriter& writer) : core_(core), writer_(writer) {}
  /// The writer, and all of the participant, may have been destroyed before.
  ~WrittenMemory() override;
  /// Gives up the memory. The writer is removed, but still exists.
  void end();

  void add_reader(const Guid& reader);
  void remove_reader(const Guid& reader);
  void on_answer(const GuidPrefix& from, const MemoryAnswer& answer);
  /// True if this writer waits for the segment with this number.
  bool waits_for(std::uint64_t id) const { return awaited_ && awaited_->id == id; }
  void on_prepared(memory::MemoryResult<memory::SampleSlots> slots, MonotonicTime now);

  std::optional<MemoryReference> store(const Change& change, SequenceNumber needed_from,
                                       MonotonicTime now) override;

 private:
  using Form = MemoryForm;
  /// A participant with matched readers.
  struct ReadingParticipant {
    enum class State : std::uint8_t { waiting, offered, mapped };
    std::set<EntityId> readers = {};
    State state = State::waiting;
    int tries = 0;
    MonotonicTime next = {};    ///< when it is offered the memory, or its answer is overdue
    bool is_used = false;       ///< an event told that it reads the memory
    std::string identity = {};  ///< proven, since it was offered memory
  };
  /// A segment that is being made or wiped. One that is being wiped is also mapped by others.
  struct AwaitedSegment {
    std::uint64_t id = 0;
    std::size_t largest = 0, octets = 0;
    Form form = Form::none;
    KeptMemory::Holders holders = {};
    std::string leaver = {};  ///< the identity for which it counts if it is kept again
  };

  const EntityId& id() const { return writer_.guid().entity; }
  /// Returns the form in which payloads may stand in memory, as the governance demands.
  Form form() const;
  void report_all(std::string_view why);
  /// Returns false if the payload cannot go through memory.
  bool prepare(std::size_t payload_size, MonotonicTime now);
  /// Asks for a segment for payloads of up to `largest` octets.
  memory::MemoryResult<void> request_segment(std::size_t largest);
  /// Uses a former segment again if all participants that may have it may read, and more of them
  /// have it than have this one.
  bool reuse(std::size_t needed);
  bool may_all_read(const KeptMemory::Holders& holders) const;
  /// For `leaver` see KeptMemory.
  void give_up(std::string leaver = {});
  void stop_waiting();
  void offer_to_all(MonotonicTime now);
  void offer(const GuidPrefix& prefix, ReadingParticipant& reading, MonotonicTime now);
  void note_refusal(const GuidPrefix& prefix, ReadingParticipant& reading,
                    memory::MemoryRefusal why, MonotonicTime now);
  void set_mapped(const GuidPrefix& prefix, ReadingParticipant& reading);
  void set_waiting(const GuidPrefix& prefix, ReadingParticipant& reading);
  void note_full(MonotonicTime now);
  std::optional<MemoryReference> put(const Change& change, SequenceNumber needed_from,
                                     MonotonicTime now);

  MemoryCore& core_;
  StatefulWriter& writer_;
  std::map<GuidPrefix, ReadingParticipant> readings_;
  std::size_t mapped_ = 0;  ///< how many of them have mapped it
  std::optional<AwaitedSegment> awaited_;
  std::optional<memory::SampleSlots> slots_;
  /// Participants that were offered this segment, and may have mapped it whatever they answer.
  KeptMemory::Holders holders_;
  bool may_reuse_ = false;   ///< a participant was added since reuse() was tried
  std::size_t largest_ = 0;  ///< the largest payload of any segment until now
  Form form_ = Form::none;   ///< the form of the payloads in the slots
  int full_ = 0;             ///< samples in a row that found no free slot
  /// When the next one may be requested after one could not be made.
  MonotonicTime next_segment_ = {};
  /// Limits the segments, because a peer whose readers come and go costs one each time.
  WorkBudget segments_{16, std::chrono::seconds(1), {}};
};

}  // namespace ddssec::rtps
