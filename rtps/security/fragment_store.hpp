// Reassembles fragmented messages of the stateless endpoint (Cyclone DDS sends such messages). An
// attacker can send fragments in any name. So several versions of each fragment are kept, with low
// limits for each sender and for all senders.
#pragma once

#include <deque>

#include "rtps/budget/source_address.hpp"
#include "rtps/budget/work_budget.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {

/// The incomplete messages of all senders. Its limits hold whatever arrives.
class FragmentStore {
 public:
  /// Large enough for certificates, permissions and more.
  static constexpr std::uint32_t kMaxMessage = 256 << 10;
  /// Smaller fragments are accepted only for messages of few fragments: no product sends them
  /// otherwise.
  static constexpr std::uint16_t kMinFragmentSize = 512;
  static constexpr std::uint32_t kMaxSmallFragments = 8;
  /// Limit for the octets of each sender, including a fixed price for each datagram, so that small
  /// datagrams are also limited.
  static constexpr std::size_t kMaxOctetsPerSender = 2 * kMaxMessage;
  static constexpr std::size_t kPricePerFragment = 512;
  /// A sender is a participant and the address that sends in its name. The address with the most
  /// senders loses one first.
  static constexpr std::size_t kMaxSenders = 16;
  /// The fragments of a message arrive close together.
  static constexpr MonotonicTime kLife = std::chrono::seconds(2);
  /// Limits for one arriving datagram: the versions of each fragment that are considered, latest
  /// first, and the messages that are assembled from them.
  static constexpr std::size_t kMaxForms = 8;
  static constexpr std::size_t kMaxMessages = 8;
  /// Limits for all senders together: messages other than the first one, and large messages.
  static constexpr int kMaxMore = 256;
  static constexpr MonotonicTime kMorePeriod = std::chrono::microseconds(250);
  static constexpr std::uint32_t kLarge = 16 << 10;

  /// Adds fragments. Returns the messages that they may form, the likeliest first; empty while a
  /// fragment is missing. It is not known yet which message is honest, so their fragments are kept.
  std::vector<Bytes> add(const GuidPrefix& sender, const DataFrag& frag, MonotonicTime now,
                         const SourceAddress& source = {});
  void forget(const GuidPrefix& sender);
  /// Returns the number of fragments that are kept.
  std::size_t size() const;

 private:
  /// The consecutive fragments of one datagram.
  struct Run {
    SequenceNumber number;
    std::uint16_t fragment_size;
    std::uint32_t sample_size;
    std::uint32_t first;  ///< index of the first fragment
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
    std::deque<Run> runs = {};  ///< latest last
    std::size_t price = 0;
    std::size_t fragments = 0;  ///< in all runs

    void drop(std::deque<Run>::iterator at);
    void keep(const DataFrag& frag, MonotonicTime now);
  };
  /// For each fragment of a message, the versions that arrived, latest first.
  using Forms = std::vector<std::vector<BytesView>>;

  Sender& place_for(const GuidPrefix& prefix, const SourceAddress& source, MonotonicTime now);
  void make_room(const SourceAddress& newcomer);
  static std::optional<Forms> forms_of(const Sender& sender, const DataFrag& frag);
  std::vector<Bytes> messages_of(const Forms& forms, MonotonicTime now);

  std::deque<Sender> senders_;  ///< in the order of their latest fragment, latest last
  WorkBudget more_{kMaxMore, kMorePeriod, {}};
};

}  // namespace ddssec::rtps
