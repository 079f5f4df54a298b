// Puts fragmented messages of the stateless endpoint together (Cyclone DDS sends such). An attacker
// can send fragments in any name, so that of each fragment several are kept, and little of each
// sender and of all.
#pragma once

#include <deque>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {

class FragmentStore {
 public:
  /// Certificates, permissions and more fit.
  static constexpr std::uint32_t kLargestMessage = 256 << 10;
  /// Smaller fragments than that are for messages of few: no product makes them.
  static constexpr std::uint16_t kMinFragmentSize = 512;
  static constexpr std::uint32_t kMaxSmallFragments = 8;
  /// Octets of each sender, with a price for each datagram so that small ones are few, too.
  static constexpr std::size_t kMostOctetsPerSender = 2 * kLargestMessage;
  static constexpr std::size_t kPricePerFragment = 512;
  /// A sender is a participant and the address that speaks in its name. The address with most
  /// senders gives way first.
  static constexpr std::size_t kMostSenders = 16;
  /// The fragments of a message follow each other closely.
  static constexpr MonotonicTime kLife = std::chrono::seconds(2);
  /// Of one fragment that is there in several forms, so many are looked at, and so many messages
  /// are made of one that comes: the first of what came latest.
  static constexpr std::size_t kMostForms = 8;
  static constexpr std::size_t kMostMessages = 8;
  /// Messages other than the first, and large ones, of all senders.
  static constexpr int kMostMore = 256;
  static constexpr MonotonicTime kMorePeriod = std::chrono::microseconds(250);
  static constexpr std::uint32_t kLarge = 16 << 10;

  /// What the fragments may come to, the likeliest first: nothing as long as one is missing. It
  /// is not known yet which of them is honest, so what they were made of stays.
  std::vector<Bytes> add(const GuidPrefix& sender, const DataFrag& frag, MonotonicTime now,
                         const SourceAddress& source = {});
  void forget(const GuidPrefix& sender);
  /// Fragments that are kept.
  std::size_t size() const;

 private:
  /// The fragments of one datagram, which follow each other.
  struct Run {
    SequenceNumber number;
    std::uint16_t fragment_size;
    std::uint32_t sample_size;
    std::uint32_t first;  ///< index of the first one
    std::uint32_t count;
    Bytes octets;
    MonotonicTime since;

    bool belongs_to(const DataFrag& frag) const {
      return number == frag.sequence_number && fragment_size == frag.fragment_size &&
             sample_size == frag.sample_size;
    }
    bool repeats(const DataFrag& frag) const;
    BytesView fragment(std::uint32_t index) const;
    std::size_t price() const { return octets.size() + kPricePerFragment; }
  };
  struct Sender {
    GuidPrefix prefix;
    SourceAddress source;
    std::deque<Run> runs = {};  ///< the latest last
    std::size_t price = 0;
    std::size_t fragments = 0;  ///< in all of them

    void drop(std::deque<Run>::iterator at);
    void keep(const DataFrag& frag, MonotonicTime now);
  };
  /// For each fragment of a message those that came, the latest first.
  using Forms = std::vector<std::vector<BytesView>>;

  Sender& place_for(const GuidPrefix& prefix, const SourceAddress& source, MonotonicTime now);
  void make_room(const SourceAddress& newcomer);
  static std::optional<Forms> forms_of(const Sender& sender, const DataFrag& frag);
  std::vector<Bytes> messages_of(const Forms& forms, MonotonicTime now);

  std::deque<Sender> senders_;  ///< who spoke latest last
  WorkBudget more_{kMostMore, kMorePeriod, {}};
};

}  // namespace ddssec::rtps
