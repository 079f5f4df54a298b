// Packs submessages into messages and hands these to a transport.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "rtps/budget/amplification_limit.hpp"
#include "rtps/reliability/send_protection.hpp"
#include "rtps/transport/transport.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/info_destination.hpp"
#include "wire/info_timestamp.hpp"

namespace ddssec::rtps {

/// The destination of a submessage.
struct Destination {
  GuidPrefix prefix = {};                   ///< zero: everybody at the locators
  std::span<const Locator> locators = {};   ///< borrowed for the call
  std::uint8_t dscp = 0;                    ///< see Outgoing
  std::size_t interface = kEveryInterface;  ///< see Outgoing
  GuidPrefix charged = {};  ///< whose AmplificationLimit counts; zero: that of `prefix`
};

/// Where a submessage goes, and which of the readers there it is for.
struct Receiver {
  Destination to;
  EntityId reader = kEntityIdUnknown;  ///< unknown: all that matched
};

/// Submessages for the same locators share a message until it is full or flushed, and the messages
/// of a large sample a call of the transport. Nothing is allocated but for more messages at once
/// than ever before. Not thread-safe.
class MessageSender {
 public:
  /// As Cyclone DDS: fits two jumbo frames; larger samples go in fragments.
  static constexpr std::size_t kLargestMessage = 14720;
  /// The largest fragment that fits such a message.
  static constexpr std::uint16_t kLargestFragment = 14336;
  /// What fits a UDP datagram: where all receivers are on this machine, and of protected messages.
  static constexpr std::size_t kLargestDatagram = 64000;
  /// A protected message of so many octets to receivers on this machine is full: what was added
  /// last and the receivers' MACs (DDS-Security 9.5.3.3.4) have room behind it.
  static constexpr std::size_t kFullProtected = 46000;

  /// Full messages that wait for more of the same sample, and their octets: receivers' buffers are
  /// small.
  static constexpr std::size_t kMostWaiting = 8;
  static constexpr std::size_t kMostWaitingOctets = std::size_t{128} << 10;

  MessageSender(Transport& transport, const GuidPrefix& prefix);

  /// From now on what `protection` says is encoded; it outlives the sender's use.
  void protect_with(SendProtection& protection);

  template <class S>
  void add(const Destination& to, const S& submessage) {
    put(to, nullptr, submessage);
  }
  /// The time of the submessages behind it, in this message only.
  template <class S>
  void add(const Destination& to, const InfoTimestamp& time, const S& submessage) {
    put(to, &time, submessage);
  }
  /// To a participant that has not authenticated, which knows none of our keys.
  template <class S>
  void add_unauthenticated(const Destination& to, const S& submessage) {
    put(to, nullptr, submessage, kStatelessMessageWriter);
  }
  /// What those who are limited may be sent. What exceeds that is not sent.
  AmplificationLimit& limit() { return limit_; }
  /// What was added goes out; while something gathers, at the end of that.
  void flush();
  /// At once: before keys that it needs are forgotten, or where it is not to share a message.
  void flush_now();
  /// While one lives nothing is flushed: what one event brings about shares messages.
  class Gathering {
   public:
    explicit Gathering(MessageSender& sender) : sender_(sender) { ++sender_.gatherings_; }
    ~Gathering() {
      if (--sender_.gatherings_ == 0 && sender_.flush_wanted_) sender_.flush_now();
    }
    Gathering(const Gathering&) = delete;
    Gathering& operator=(const Gathering&) = delete;

   private:
    MessageSender& sender_;
  };
  /// Samples above this many octets go in fragments of it; at most kLargestFragment.
  void fragment_at(std::uint32_t size) {
    fragment_size_ =
        static_cast<std::uint16_t>(std::clamp<std::uint32_t>(size, 1, kLargestFragment));
  }
  std::uint16_t fragment_size() const { return fragment_size_; }
  /// The writer's submessages are protected and the INFO_TS before them is not.
  bool leaves_time_unprotected(const EntityId& writer) const;
  /// How many octets make the message full that waits, or the last that did.
  std::size_t full_size() const { return full_size_; }

  /// From now on what was added may wait for more: flush is called when flush_by says so.
  void allow_lingering() { may_linger_ = true; }
  bool may_linger() const { return may_linger_; }
  /// Instead of a flush: at `deadline` at the latest.
  void linger(MonotonicTime deadline) { flush_by_ = std::min(flush_by_, deadline); }
  /// kNever: nothing waits.
  MonotonicTime flush_by() const { return flush_by_; }

  /// A sample came: the next write may be an answer that a peer waits for.
  void note_sample() { ++samples_heard_; }
  std::uint32_t samples_heard() const { return samples_heard_; }

 private:
  /// Which of our endpoints speaks and to which of theirs.
  struct Ends {
    EntityId from, to;
  };
  template <class S>
  static Ends ends_of(const S& submessage) {
    if constexpr (requires { submessage.missing; })
      return {submessage.reader, submessage.writer};
    else
      return {submessage.writer, submessage.reader};
  }

  template <class S>
  void put(const Destination& to, const InfoTimestamp* time, const S& submessage) {
    put(to, time, submessage, ends_of(submessage).from);
  }
  /// Protected as what `as` sends.
  template <class S>
  void put(const Destination& to, const InfoTimestamp* time, const S& submessage,
           const EntityId& as) {
    const auto ends = ends_of(submessage);
    const auto levels = protection_ ? protection_->levels(as) : SendProtection::Levels{};
    for (int attempt = 0; attempt < 2; ++attempt) {
      begin(to, levels.message);
      const auto before = out_.size();
      if (time != nullptr) write(out_, *time);
      if (!write_protected(levels, {to.prefix, ends.to}, ends.from, submessage)) {
        out_.rewind(before);
        return;
      }
      if (!out_.overflowed()) return;
      out_.rewind(before);
      finish_message();
    }
  }
  /// False: it could not be protected.
  template <class S>
  bool write_protected(const SendProtection::Levels& levels, const Guid& receiver,
                       const EntityId& sender, S submessage) {
    if constexpr (requires { submessage.payload; })
      if (levels.payload && !submessage.payload.empty()) {
        const auto octets = protected_payload(sender, submessage.payload);
        if (!octets) return false;
        submessage.payload = *octets;
      }
    if (!levels.submessage) {
      write(out_, submessage);
      return true;
    }
    SpanWriter plain(plain_);
    write(plain, submessage);
    const bool done =
        !plain.overflowed() && write_protected_submessage(sender, receiver, plain.view());
    if (sender == kVolatileMessageWriter) wipe(MutableBytes(plain_).first(plain.size()));  // keys
    return done;
  }
  std::optional<BytesView> protected_payload(const EntityId& writer, BytesView plain);
  bool write_protected_submessage(const EntityId& sender, const Guid& receiver, BytesView plain);
  void begin(const Destination& to, SendProtection::Wrap wrap);
  void begin_message(std::span<const Locator> to, bool wrapped);
  /// It waits for the flush, or for kMostWaiting of its like.
  void finish_message();
  void wait_for_more(BytesView message);
  void send_waiting();
  void send_limited(const Outgoing& out);
  MutableBytes slot(std::size_t index);

  Transport& transport_;
  Header header_;
  SendProtection* protection_ = nullptr;
  Bytes buffer_, payload_, plain_;
  std::array<Bytes, kMostWaiting> slots_;         ///< messages as they are sent
  std::array<BytesView, kMostWaiting> messages_;  ///< those that wait
  std::size_t waiting_ = 0;
  std::size_t waiting_octets_ = 0;
  std::size_t slot_size_ = kLargestMessage;
  std::size_t full_size_ = kLargestMessage;
  SpanWriter out_;  ///< the message that is written, in the next slot or to be protected into it
  std::vector<Locator> to_;  ///< of all that waits
  std::uint8_t dscp_ = 0;    ///< the same
  std::size_t interface_ = kEveryInterface;
  GuidPrefix destination_;  ///< of the last submessage
  GuidPrefix receiver_;     ///< of all submessages in the message, or zero
  GuidPrefix limited_;      ///< whose limit all that waits is charged to, or zero
  AmplificationLimit limit_;
  SendProtection::Wrap wrap_ = SendProtection::Wrap::none;
  bool may_linger_ = false;
  MonotonicTime flush_by_ = kNever;
  int gatherings_ = 0;
  bool flush_wanted_ = false;
  std::uint32_t samples_heard_ = 0;
  std::uint16_t fragment_size_ = kLargestFragment;
};

}  // namespace ddssec::rtps
