// Checks fragmented announcements of one participant as the fragments come.
//
// A host reassembles a sample from all fragments that it received under one sequence number, and
// trusts the result. Which fragments it keeps and which it drops cannot be known here: its limits
// are configurable, and it drops without notice. So the check does not depend on that: all
// fragments that ever pass under one number belong to one content, which was read here in order.
// Whichever fragments the host joins, it gets that content or a part of it.
//
// - Fragments pass in order only.
// - A fragment that passed may come again only unchanged: its digest is stored as long as its
//   sample is known.
// - Only the sample with the lowest number is forgotten, and only after the host has acknowledged
//   it: the host then needs no fragment up to that number any more. None of these passes again.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "plugins/cryptography/announced_endpoints.hpp"
#include "plugins/cryptography/builtin_names.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "plugins/cryptography/discovery_work.hpp"
#include "plugins/cryptography/type_information.hpp"

namespace ddssec::cryptography {

/// The checks for one participant. Thread-safe.
class FragmentWalks {
 public:
  /// Limit for a sample, in fragments: 516 kB with Cyclone DDS.
  static constexpr std::size_t kMaxOfSample = 384;
  static constexpr std::uint32_t kMaxOctets = 1 << 20;  ///< limit for a sample, in octets
  static constexpr std::size_t kMaxFragments = 2048;    ///< limit for a writer: 64 kB of digests
  /// Limit for a writer: two windows of an ACKNACK.
  static constexpr std::size_t kMaxSamples = 512;
  /// Additional space for numbers below the highest one: the host needs the lowest first.
  static constexpr std::size_t kSpareSamples = 64, kSpareFragments = kMaxOfSample;
  /// How long the lowest sample is kept, for other participants of this process.
  static constexpr MonotonicTime kKept = std::chrono::seconds(5);

  /// Checks one DATA_FRAG that is not a whole sample, from a writer whose samples are parameter
  /// lists. Returns the position of the parameter id of type information in its payload, also for a
  /// retransmitted fragment. The sample counts in `announced` from its first fragment on.
  ///
  /// Errors: builtin_source_mismatch, builtin_source_unreadable. builtin_fragment_early: an earlier
  /// fragment is missing or there is no space now, so it will be requested again; or its sample is
  /// forgotten, and the sender serves another participant.
  Result<TypeInformationAt> check(const DiscoveryTopic& topic, const Owner& owner,
                                  const DataPiece& piece, AnnouncedEndpoints& announced,
                                  MonotonicTime now);

 private:
  struct Sample {
    std::uint32_t size;
    std::uint16_t fragment_size;
    std::size_t count;  ///< number of its fragments
    MonotonicTime last_progress;
    /// nullptr if the sample is complete.
    std::unique_ptr<ParameterWalk> walk = std::make_unique<ParameterWalk>();
    std::vector<Sha256Digest> passed = {};
    TypeInformationAt type_information = {};
  };
  using Samples = std::map<std::uint64_t, Sample>;  ///< by writerSN
  struct Writer {
    Samples samples = {};
    std::size_t fragments = 0;          ///< fragments of all samples, received or not
    std::uint64_t forgotten_until = 0;  ///< the highest number of a forgotten sample
    void erase(Samples::iterator sample);
    bool is_full(std::uint64_t number, std::size_t fragments_more) const;
  };

  Result<Samples::iterator> sample_of(const DiscoveryTopic& topic, Writer& writer,
                                      const DataPiece& piece, AnnouncedEndpoints& announced,
                                      MonotonicTime now);
  static Status make_room(const DiscoveryTopic& topic, Writer& writer, std::uint64_t number,
                          std::size_t fragments, const AnnouncedEndpoints& announced,
                          MonotonicTime now);
  Status read(const DiscoveryTopic& topic, const Owner& owner, const DataPiece& piece,
              Sample& sample, AnnouncedEndpoints& announced, MonotonicTime now) const;
  Status continue_sample(const DiscoveryTopic& topic, const Owner& owner, const DataPiece& piece,
                         BytesView octets, const std::vector<Sha256Digest>& added, Sample& sample,
                         AnnouncedEndpoints& announced) const;

  std::mutex mutex_;
  std::map<EntityId, Writer> writers_;  ///< at most one for each topic
};

/// The known announcements of one participant.
struct PeerDiscovery {
  FragmentWalks walks = {};
  AnnouncedEndpoints announced = {};
  DiscoveryWork work = {};
};

/// Finds the announcements of participants.
class DiscoveryOfPeers {
 public:
  virtual ~DiscoveryOfPeers() = default;
  /// Returns the announcements of that participant; nullptr if it is not known now.
  virtual PeerDiscovery* of(const GuidPrefix& owner) = 0;
  virtual MonotonicTime now() const = 0;
  /// True for a writer whose samples are not heard in the clear: no honest participant sends them.
  virtual bool is_closed(const EntityId& /*writer*/) const { return false; }
};

}  // namespace ddssec::cryptography
