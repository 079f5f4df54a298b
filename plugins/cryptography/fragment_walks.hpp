// Fragmented announcements of one participant, judged as they come.
//
// A host puts the fragments of a sample together itself, from whatever it was given under one
// sequence number, and believes the result. So each octet that it gets must be one that was read
// here, in the place where the host will read it: fragments pass in order only, one that comes
// again must be what it was before, and a sample that was given up half-way never goes on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "base/hash.hpp"
#include "plugins/cryptography/builtin_names.hpp"
#include "plugins/cryptography/data_piece.hpp"

namespace ddssec::cryptography {

/// Thread-safe.
class FragmentWalks {
 public:
  static constexpr std::size_t kMostOfSample = 384;   ///< fragments: 516 kB by Cyclone DDS
  static constexpr std::size_t kMostFragments = 512;  ///< of a writer: 16 kB of digests
  static constexpr std::size_t kMostSamples = 32;     ///< of a writer
  static constexpr std::size_t kMostGivenUp = 64;     ///< numbers, of a writer
  static constexpr std::uint64_t kPiecesUntilStale = 4096;

  /// One DATA_FRAG that is not a whole sample, of a writer whose samples are parameter lists.
  /// Errors: builtin_source_mismatch, builtin_source_unreadable; builtin_fragment_early: one before
  /// it is missing, or there is no room now, and it will be asked for again.
  Status take(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece);

 private:
  struct Sample {
    std::uint32_t size;
    std::uint16_t fragment_size;
    std::size_t count;            ///< of its fragments
    std::uint64_t last_progress;  ///< as pieces_ counts
    ParameterWalk walk = {};
    std::vector<Sha256Digest> passed = {};
    bool is_whole() const { return passed.size() == count; }
  };
  using Samples = std::map<std::uint64_t, Sample>;  ///< by writerSN
  struct Writer {
    Samples samples = {};
    std::size_t fragments = 0;  ///< of all of them, whether they came or not
    std::set<std::uint64_t> given_up = {};
    std::uint64_t given_up_until = 0;  ///< all that are not in `samples`, up to this number
  };

  Result<Samples::iterator> sample_of(const BuiltinTopic& topic, Writer& writer,
                                      const DataPiece& piece);
  Status make_room(Writer& writer, std::uint64_t number, std::size_t fragments);
  Samples::iterator dispensable(Writer& writer, std::uint64_t number) const;
  Status read(const BuiltinTopic& topic, const Owner& owner, const DataPiece& piece,
              Sample& sample) const;

  std::mutex mutex_;
  std::map<EntityId, Writer> writers_;  ///< as many as there are topics
  std::uint64_t pieces_ = 0;            ///< that came
};

/// Whose fragments are where.
class WalksOfPeers {
 public:
  virtual ~WalksOfPeers() = default;
  /// Null: of nobody that is known now.
  virtual FragmentWalks* of(const GuidPrefix& owner) = 0;
};

}  // namespace ddssec::cryptography
