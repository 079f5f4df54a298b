// Which received changes become samples of a DataReader. No I/O, clock or lock: the caller brings
// times and serializes calls.
#pragma once

#include <atomic>

#include "rtps/dcps/key_protection.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/dcps/seen_originals.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

/// Changes that pass the content filter, belong to an instance and came from no writer before
/// (DURABILITY), in a ReaderCache.
class ReceivedSamples {
 public:
  /// `type` outlives it.
  ReceivedSamples(const Qos& qos, const TypeSupport& type);

  /// Other policies of a reader that is not enabled yet.
  void reset(const Qos& qos);
  /// A reader that asks for history: a sample that several writers hold is taken once.
  void expect_history() { seen_.emplace(); }

  enum class Outcome : std::uint8_t {
    stored,
    unseen,          ///< taken, and a reader does not see it
    rejected,        ///< nothing has changed; it may be offered again
    unreadable_key,  ///< taken: the end of an instance that cannot be named
  };
  struct Received {
    Outcome outcome = Outcome::unseen;
    ReaderCache::Stored stored = {};  ///< of `stored` and `rejected`
  };
  /// `filter`: the reader's content filter; nullptr: none.
  Received take(Change& change, BoundFilter* filter, const KeyProtection& keys, const Moment& at);

  ReaderCache& cache() { return *cache_; }
  const ReaderCache& cache() const { return *cache_; }
  /// Samples that could not be read; never reset. Any thread may ask and count.
  std::uint64_t malformed() const { return malformed_; }
  void count_malformed() { ++malformed_; }

 private:
  bool passes(const Change& change, BoundFilter& filter);
  /// False: it has a key that cannot be read.
  bool name_instance(Change& change, const KeyProtection& keys) const;

  const TypeSupport& type_;
  std::optional<ReaderCache> cache_;
  std::optional<SeenOriginals> seen_;
  std::atomic<std::uint64_t> malformed_ = 0;
};

}  // namespace ddssec::rtps
