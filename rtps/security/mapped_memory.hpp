// The memory of remote writers that this participant has mapped.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "rtps/budget/work_budget.hpp"
#include "rtps/memory/descriptor_passing.hpp"
#include "rtps/reliability/payload.hpp"
#include "rtps/security/memory_messages.hpp"

namespace ddssec::rtps {

/// Maps the memory of writers that matched a local reader. For a while it keeps two segments of a
/// writer, because references to the former one may still be on their way. No clock or lock, and
/// never blocks.
class MappedMemory {
 public:
  /// How long a descriptor may take to arrive.
  static constexpr MonotonicTime kMaxRequest =
      memory::DescriptorPassing::kMaxRequest + std::chrono::seconds(1);
  /// How long large samples may arrive in messages before the lack of an offer is reported.
  static constexpr MonotonicTime kMaxWait = std::chrono::seconds(2);
  /// Samples from this size on are large, in octets.
  static constexpr std::size_t kMinLarge = std::size_t{8} << 10;
  /// How long the former segment of a writer stays mapped.
  static constexpr MonotonicTime kFormer = std::chrono::seconds(5);
  /// Limits for the segments of all writers, and of those of one participant.
  static constexpr std::size_t kMaxSegments = 512, kMaxOfOne = 128;
  /// Limits for the octets of these segments. Page tables for them count for this process: one
  /// octet for 512.
  static constexpr std::size_t kMaxOctets = std::size_t{4} << 30;
  static constexpr std::size_t kMaxOctetsOfOne = std::size_t{1} << 30;
  /// Limit for the octets that are copied for the participants of one identity: in a second, and at
  /// once. A reference costs its sender little, but costs this participant the copy of a payload.
  static constexpr std::int64_t kCopiedInASecond = std::int64_t{2} << 30;
  static constexpr std::int64_t kCopiedAtOnce = kCopiedInASecond / 4;
  /// Limit for the requests that one participant's offers wait for.
  static constexpr std::size_t kMaxRequestsOfOne = 8;
  /// Limit for a payload, in octets, with its protection.
  static constexpr std::uint32_t kMaxPayload = (std::uint32_t{16} << 20) + 64;

  /// Called with the answer to an offer.
  using Answer = std::function<void(const GuidPrefix& to, const MemoryAnswer& answer)>;
  /// Returns the proven identity of a participant.
  using IdentityOf = std::function<std::string(const GuidPrefix&)>;
  /// Called once for a writer of this machine that goes on sending large samples in messages, and
  /// has offered no memory.
  using NotOffered = std::function<void(const GuidPrefix& from)>;
  /// `passing` must outlive this object. Its descriptor is readable when `serve` must be called. If
  /// `identity_of` is empty, each participant counts as an identity.
  MappedMemory(memory::DescriptorPassing& passing, Answer answer, IdentityOf identity_of = {},
               NotOffered not_offered = {})
      : passing_(passing),
        answer_(std::move(answer)),
        identity_of_(std::move(identity_of)),
        not_offered_(std::move(not_offered)) {}

  /// Note that the reader has matched the writer, or no longer does. `is_here` is true if the
  /// writer is on this machine.
  void add_reader(const Guid& writer, const EntityId& reader, bool is_here = true);
  void remove_reader(const Guid& writer, const EntityId& reader);
  /// True if a local reader has matched the writer.
  bool has_writer(const Guid& writer) const { return writers_.contains(writer); }
  /// Notes that a sample of so many octets, or a part of one, arrived in a message.
  void note_message(const Guid& writer, std::size_t octets, MonotonicTime now);
  /// Handles the offer of a peer's memory for one of its writers.
  void on_offer(const GuidPrefix& from, MemoryOffer offer, MonotonicTime now);
  /// Takes descriptors that have arrived, and unmaps former segments.
  void serve(MonotonicTime now);
  /// Returns when `serve` must be called even if nothing arrives.
  MonotonicTime next_tick() const;

  /// Returns a copy of a payload. Empty if the payload is gone, or if the reference leads nowhere.
  /// If the segment is not mapped, the writer's participant is told so.
  Payload fetch(const Guid& writer, const MemoryReference& reference, MonotonicTime now);

  std::size_t segments() const { return segments_; }

 private:
  struct Segment {
    std::uint64_t id = 0;
    memory::MappedSegment mapped;
  };
  struct Request {
    std::uint64_t segment = 0;
    std::uint64_t id = 0;
    MonotonicTime until{};
  };
  /// Octets that may be copied.
  struct Copies {
    Copies(std::int64_t octets, MonotonicTime now) : left(octets), since(now) {}
    std::int64_t left;
    MonotonicTime since;
  };
  struct WriterMemory {
    std::set<EntityId> readers = {};
    std::optional<Request> request = {};
    std::optional<Segment> latest = {}, former = {};
    MonotonicTime former_until = {};
    WorkBudget offers{4, std::chrono::seconds(1), {}};
    WorkBudget complaints{1, std::chrono::seconds(2), {}};
    bool expects_offer = false;  ///< no offer has arrived, and that was not reported
    /// When large samples began to arrive in messages.
    std::optional<MonotonicTime> large_since = {};
  };

  void answer(const Guid& writer, std::uint64_t segment,
              std::optional<memory::MemoryRefusal> refusal);
  bool has_room(const GuidPrefix& from) const;
  bool has_octets_for(const GuidPrefix& from, std::size_t more) const;
  std::shared_ptr<Copies> copies_for(const GuidPrefix& from, MonotonicTime now);
  bool may_copy(const GuidPrefix& from, std::size_t octets, MonotonicTime now);
  void on_fetched(memory::DescriptorPassing::FetchedSegment fetched, MonotonicTime now);
  void end_request(WriterMemory& it);
  void abandon_request(const GuidPrefix& from, WriterMemory& it);
  void keep(WriterMemory& it, Segment segment, MonotonicTime now);
  void forget_former(WriterMemory& it);

  memory::DescriptorPassing& passing_;
  const Answer answer_;
  const IdentityOf identity_of_;
  const NotOffered not_offered_;
  std::map<Guid, WriterMemory> writers_;
  std::map<GuidPrefix, std::shared_ptr<Copies>> copies_;
  std::map<std::string, std::weak_ptr<Copies>> of_identities_;
  /// Requests whose results are no longer wanted, and have not arrived yet.
  std::map<std::uint64_t, GuidPrefix> abandoned_;
  std::size_t requests_ = 0, segments_ = 0, formers_ = 0;
};

}  // namespace ddssec::rtps
