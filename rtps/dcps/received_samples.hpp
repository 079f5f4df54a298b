// Decides which received changes become samples of a DataReader. No I/O, clock or lock: the caller
// passes times and serializes calls.
#pragma once

#include <atomic>

#include "rtps/dcps/key_protection.hpp"
#include "rtps/dcps/reader_cache.hpp"
#include "rtps/dcps/seen_originals.hpp"
#include "rtps/dcps/type_support.hpp"

namespace ddssec::rtps {

/// Stores changes in a ReaderCache if they pass the content filter, if their instance is known, and
/// if no other writer has delivered them before (DURABILITY).
class ReceivedSamples {
 public:
  /// `type` and `queries` (see HeldInstances) must outlive this object.
  ReceivedSamples(const Qos& qos, const TypeSupport& type, const Queries& queries = kNoQueries);

  /// Applies changed policies of a reader that is not enabled yet.
  void reset(const Qos& qos);
  /// Prepares for history: a sample that several writers hold is then taken only once.
  void expect_history() { seen_.emplace(); }

  enum class Reception : std::uint8_t {
    stored,
    unseen,          ///< taken, but the reader does not see it
    rejected,        ///< nothing has changed; the change may be offered again
    unreadable_key,  ///< taken: the end of an instance whose key cannot be read
  };
  struct ReceptionReport {
    Reception outcome = Reception::unseen;
    ReaderCache::StoreReport stored = {};  ///< set if the outcome is `stored` or `rejected`
  };
  /// Takes a change. `filter` is the reader's content filter, or nullptr if it has none.
  ReceptionReport receive(Change& change, BoundFilter* filter, const KeyProtection& keys,
                          const Moment& at);

  /// Returns the instance that `receive` would find. The default value if the type has no key, or
  /// if the key of this change cannot be read.
  KeyHash instance_of(const Change& change, const KeyProtection& keys) const;

  ReaderCache& cache() { return *cache_; }
  const ReaderCache& cache() const { return *cache_; }
  /// Returns the number of samples that could not be deserialized; never reset. Any thread may read
  /// and count.
  std::uint64_t malformed() const { return malformed_; }
  void count_malformed() { ++malformed_; }

 private:
  bool passes(const Change& change, BoundFilter& filter);
  std::optional<KeyHash> key_of(const Change& change, const KeyProtection& keys) const;
  /// Sets the instance of the change. Returns false if the type has a key that cannot be read.
  bool name_instance(Change& change, const KeyProtection& keys) const;

  const TypeSupport& type_;
  const Queries& queries_;
  std::optional<ReaderCache> cache_;
  std::optional<SeenOriginals> seen_;
  std::atomic<std::uint64_t> malformed_ = 0;
};

}  // namespace ddssec::rtps
