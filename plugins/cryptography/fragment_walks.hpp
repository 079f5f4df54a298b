// Fragmented announcements of one participant, judged as they come.
//
// A host puts the fragments of a sample together itself, from whatever it was given under one
// sequence number, and believes the result. Which fragments it keeps and which it drops cannot be
// known here: its limits are configurable, and it drops without a word. So the rule does not depend
// on it: all fragments that ever pass under one number are of one content, which was read here in
// order. Whichever of them the host joins, it gets that content or a part of it.
//
// - Fragments pass in order only.
// - One that passed comes again only as it was: its digest stays as long as its sample is known.
// - Only the sample with the lowest number is forgotten, once the host has acknowledged it: it
// needs
//   none up to that number any more. None of these passes again.
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
#include "plugins/cryptography/type_information.hpp"

namespace ddssec::cryptography {

/// Thread-safe.
class FragmentWalks {
 public:
  static constexpr std::size_t kMostOfSample = 384;      ///< fragments: 516 kB by Cyclone DDS
  static constexpr std::uint32_t kMostOctets = 1 << 20;  ///< of a sample
  static constexpr std::size_t kMostFragments = 2048;    ///< of a writer: 64 kB of digests
  static constexpr std::size_t kMostSamples = 512;       ///< of a writer: two windows of an ACKNACK
  /// Further ones, for numbers below the highest: the host needs the lowest first.
  static constexpr std::size_t kSpareSamples = 64, kSpareFragments = kMostOfSample;
  /// So long is the lowest kept, for other participants of this process.
  static constexpr MonotonicTime kKept = std::chrono::seconds(5);

  /// One DATA_FRAG that is not a whole sample, of a writer whose samples are parameter lists.
  /// Returns where its payload holds the parameter id of type information: also if it comes again.
  /// The sample counts in `announced` from the first one on.
  /// Errors: builtin_source_mismatch, builtin_source_unreadable; builtin_fragment_early: one before
  /// it is missing, or there is no room now, and it will be asked for again; or its sample is
  /// forgotten, and the sender serves another participant.
  Result<TypeInformationAt> take(const BuiltinTopic& topic, const Owner& owner,
                                 const DataPiece& piece, AnnouncedEndpoints& announced,
                                 MonotonicTime now);

 private:
  struct Sample {
    std::uint32_t size;
    std::uint16_t fragment_size;
    std::size_t count;  ///< of its fragments
    MonotonicTime last_progress;
    std::unique_ptr<ParameterWalk> walk = std::make_unique<ParameterWalk>();  ///< null: whole
    std::vector<Sha256Digest> passed = {};
    TypeInformationAt type_information = {};
  };
  using Samples = std::map<std::uint64_t, Sample>;  ///< by writerSN
  struct Writer {
    Samples samples = {};
    std::size_t fragments = 0;          ///< of all of them, whether they came or not
    std::uint64_t forgotten_until = 0;  ///< the highest number of a sample that was forgotten
    void erase(Samples::iterator sample);
    bool is_full(std::uint64_t number, std::size_t fragments_more) const;
  };

  Result<Samples::iterator> sample_of(const BuiltinTopic& topic, Writer& writer,
                                      const DataPiece& piece, AnnouncedEndpoints& announced,
                                      MonotonicTime now);
  static Status make_room(const BuiltinTopic& topic, Writer& writer, std::uint64_t number,
                          std::size_t fragments, const AnnouncedEndpoints& announced,
                          MonotonicTime now);
  Status read(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece, Sample& sample,
              AnnouncedEndpoints& announced, MonotonicTime now) const;
  Status go_on(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece,
               BytesView octets, const std::vector<Sha256Digest>& added, Sample& sample,
               AnnouncedEndpoints& announced) const;

  std::mutex mutex_;
  std::map<EntityId, Writer> writers_;  ///< as many as there are topics
};

/// What is known of the announcements of one participant.
struct PeerDiscovery {
  FragmentWalks walks = {};
  AnnouncedEndpoints announced = {};
};

/// Whose is where.
class DiscoveryOfPeers {
 public:
  virtual ~DiscoveryOfPeers() = default;
  /// Null: no participant of that name is known now.
  virtual PeerDiscovery* of(const GuidPrefix& owner) = 0;
  virtual MonotonicTime now() const = 0;
};

}  // namespace ddssec::cryptography
