// Fragmented announcements of one participant, judged as they come.
//
// A host puts the fragments of a sample together itself, from whatever it was given under one
// sequence number, and believes the result. So each octet that it gets must be one that was read
// here, in the place where the host will read it: fragments pass in order only, one that comes
// again must be what it was before, and a sample that was given up half-way never goes on.
//
// Anybody can send recorded fragments again. Samples that were whole once and left the table have
// places of their own, so that those fragments never take the room of new announcements.
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
#include "plugins/cryptography/type_information.hpp"

namespace ddssec::cryptography {

/// Thread-safe.
class FragmentWalks {
 public:
  static constexpr std::size_t kMostOfSample = 384;   ///< fragments: 516 kB by Cyclone DDS
  static constexpr std::size_t kMostFragments = 512;  ///< of a table: 16 kB of digests
  static constexpr std::size_t kMostSamples = 32;     ///< of a table; a writer has two
  static constexpr std::size_t kMostGivenUp = 64;     ///< numbers, of a writer
  static constexpr std::uint64_t kPiecesUntilStale = 4096;
  static constexpr std::size_t kMostOnceWhole = 256;  ///< numbers, of a writer

  /// One DATA_FRAG that is not a whole sample, of a writer whose samples are parameter lists.
  /// Returns where its payload holds the parameter id of type information: also if it comes again.
  /// Errors: builtin_source_mismatch, builtin_source_unreadable; builtin_fragment_early: one before
  /// it is missing, or there is no room now, and it will be asked for again.
  Result<TypeInformationAt> take(const BuiltinTopic& topic, const Owner& owner,
                                 const DataPiece& piece);

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
  struct Table {
    Samples samples = {};
    std::size_t fragments = 0;  ///< of all of them, whether they came or not
    void erase(Samples::iterator sample);
  };
  /// Numbers, the highest so many; of those below all count as members once one has left.
  class Numbers {
   public:
    explicit Numbers(std::size_t most) : most_(most) {}
    bool contains(std::uint64_t number) const {
      return number <= all_until_ || numbers_.contains(number);
    }
    void insert(std::uint64_t number);

   private:
    std::size_t most_;
    std::set<std::uint64_t> numbers_ = {};
    std::uint64_t all_until_ = 0;
  };
  struct Writer {
    Table fresh = {};
    Table again = {};  ///< of samples that were whole once
    Numbers once_whole = Numbers(kMostOnceWhole);
    Numbers given_up = Numbers(kMostGivenUp);
    Numbers closed = Numbers(kMostGivenUp);  ///< given up, and were whole once
  };
  struct Place {
    Table& table;
    Samples::iterator sample;
  };

  Result<Place> place_of(const BuiltinTopic& topic, Writer& writer, const DataPiece& piece);
  Status make_room(Writer& writer, std::uint64_t number, std::size_t fragments);
  Status make_room_again(Writer& writer, std::uint64_t number, std::size_t fragments) const;
  Samples::iterator oldest_whole(Samples& samples) const;
  Samples::iterator stale(Samples& samples) const;
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
