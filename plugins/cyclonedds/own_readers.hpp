// Ends of our own readers, said where peers believe them.
//
// Cyclone DDS 0.10.2 announces a reader whose discovery is protected by the protected writer of
// subscriptions, and forgets how it was protected before it says that the reader is gone: that goes
// out by the unprotected writer, outside of any protection. Our peers believe no such thing
// (closed_readers.hpp). So the end is said here, in the protected stream: a further reader of the
// host, the carrier, makes the host announce something there. What is sent in place of that
// announcement says that another reader, which the carrier's USER_DATA names, is gone. The host
// repeats it to each peer that lacks it, as any announcement.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"

namespace ddssec::cyclonedds {

/// The topic of carriers. Peers never hear of it.
inline constexpr std::string_view kCarrierTopic = "ddssec_end_of_reader";

/// What the participants of one domain of this process announced by their protected writers of
/// subscriptions. Thread-safe.
class OwnReaders {
 public:
  /// Room for what is said in place of a submessage.
  using Room = std::array<std::uint8_t, 128>;

  /// What to send for a submessage of one of our writers, before it is protected: itself, or what
  /// was written into `room`.
  BytesView said(BytesView submessage, Room& room);

  /// Those whose end was not said.
  std::vector<Guid> announced() const;
  /// Counts every reader that is announced for the first time.
  std::uint64_t count() const;
  /// A carrier was made for it.
  void ended(const Guid& reader);
  /// A participant of this process is gone.
  void forget(const GuidPrefix& participant);

 private:
  /// One announcement of a reader, or its end.
  struct Announcement;
  static std::optional<Announcement> read(BytesView submessage);
  void note(const Announcement& announcement);

  mutable std::mutex mutex_;
  std::set<Guid> announced_;
  /// As many as the host keeps announcements of readers that are gone: it never drops one.
  std::set<Guid> ended_;
  std::uint64_t count_ = 0;
};

}  // namespace ddssec::cyclonedds
