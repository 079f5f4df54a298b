// Packs submessages into messages and passes these to a transport.
#pragma once

#include <algorithm>
#include <array>
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
#include "wire/span_writer.hpp"

namespace ddssec::rtps {

/// The destination of a submessage.
struct Destination {
  GuidPrefix prefix = {};                   ///< zero: all participants at the locators
  std::span<const Locator> locators = {};   ///< borrowed for the call
  std::uint8_t dscp = 0;                    ///< see OutgoingMessages
  std::size_t interface = kEveryInterface;  ///< see OutgoingMessages
  /// The participant whose AmplificationLimit is charged; zero means that of `prefix`.
  GuidPrefix charged = {};
};

/// The destination of a submessage, and the reader there.
struct Receiver {
  Destination to;
  EntityId reader = kEntityIdUnknown;  ///< unknown: all matched readers
};

/// Packs submessages for the same locators into a message until it is full or flushed. The messages
/// of a large sample share a call of the transport. Memory is allocated only if more messages are
/// needed at once than ever before. Not thread-safe.
class MessageSender {
 public:
  /// The size of a message in octets, as in Cyclone DDS: it fits two jumbo frames. Larger samples
  /// are sent in fragments.
  static constexpr std::size_t kMaxMessage = 14720;
  /// The largest fragment that fits into such a message, in octets.
  static constexpr std::uint16_t kMaxFragment = 14336;
  /// The limit of a UDP datagram, in octets: used if all receivers are on this machine, and for
  /// protected messages.
  static constexpr std::size_t kMaxDatagram = 64000;
  /// A protected message of this many octets to receivers on this machine is full. The rest is room
  /// for the last submessage, and for the receivers' MACs (DDS-Security 1.2, clause 10.5.3.3.4). If
  /// there are too many MACs, the last submessage begins the next message.
  static constexpr std::size_t kFullProtected = 46000;

  /// Limits for full messages that wait for more of the same sample. They are low because
  /// receivers' buffers are small.
  static constexpr std::size_t kMaxWaiting = 8;
  static constexpr std::size_t kMaxWaitingOctets = std::size_t{128} << 10;

  MessageSender(Transport& transport, const GuidPrefix& prefix);

  /// Makes `protection` encode messages from now on. It must outlive the use of the sender.
  void protect_with(SendProtection& protection);

  template <class S>
  void add(const Destination& to, const S& submessage) {
    put(to, nullptr, submessage);
  }
  /// Adds a submessage with its time, which applies to this message only.
  template <class S>
  void add(const Destination& to, const InfoTimestamp& time, const S& submessage) {
    put(to, &time, submessage);
  }
  /// Adds a submessage to a participant that has not authenticated, and so has no keys.
  template <class S>
  void add_unauthenticated(const Destination& to, const S& submessage) {
    put(to, nullptr, submessage, kStatelessMessageWriter);
  }
  /// Returns the limits on the octets that are sent to unproven participants. A message above the
  /// limit is not sent.
  AmplificationLimit& amplification_limit() { return limit_; }
  /// Returns how many fragments may be sent there before the limit is reached.
  std::size_t fragments_left(const Destination& to);
  /// Sends everything that was added. While a GatheringScope exists, this happens at its end.
  void flush();
  /// Sends a whole message without changes.
  void send_alone(BytesView message, std::span<const Locator> to) {
    transport_.send_all({{&message, 1}, to});
  }
  /// Sends at once. It is for messages whose keys are about to be removed, or that must not be
  /// shared.
  void flush_now();
  /// As flush_now, in a destructor, which must not throw.
  void flush_at_end() noexcept;
  /// While an instance exists, nothing is flushed, so that the results of one event share messages.
  class GatheringScope {
   public:
    explicit GatheringScope(MessageSender& sender) : sender_(sender) { ++sender_.gatherings_; }
    ~GatheringScope() {
      if (--sender_.gatherings_ == 0 && sender_.is_flush_wanted_) sender_.flush_at_end();
    }
    GatheringScope(const GatheringScope&) = delete;
    GatheringScope& operator=(const GatheringScope&) = delete;

   private:
    MessageSender& sender_;
  };
  /// Sets the fragment size: samples with more octets than `size` are sent in fragments of that
  /// size, which is at most kMaxFragment.
  void fragment_at(std::uint32_t size) {
    fragment_size_ = static_cast<std::uint16_t>(std::clamp<std::uint32_t>(size, 1, kMaxFragment));
  }
  std::uint16_t fragment_size() const { return fragment_size_; }
  /// True if the writer's submessages are protected but the INFO_TS before them is not.
  bool leaves_time_unprotected(const EntityId& writer) const;
  /// True if the writer's payloads are protected, so that they may be all that is.
  bool protects_payload(const EntityId& writer) const;
  /// Returns the number of octets at which the waiting message, or the last one that waited, is
  /// full.
  std::size_t full_size() const { return full_size_; }

  /// Allows that submessages wait for more. The owner must then call flush at the time that
  /// flush_by returns.
  void allow_delayed_flush() { may_delay_flush_ = true; }
  bool may_delay_flush() const { return may_delay_flush_; }
  /// Requests a flush at `deadline` at the latest, instead of now.
  void delay_flush(MonotonicTime deadline) { flush_by_ = std::min(flush_by_, deadline); }
  /// Returns the time at which flush must be called; kNever if nothing waits.
  MonotonicTime flush_by() const { return flush_by_; }

  /// Notes that a sample arrived: the next write may be an answer that a peer waits for.
  void note_sample() { ++samples_heard_; }
  std::uint32_t samples_heard() const { return samples_heard_; }

 private:
  /// The local and the remote endpoint of a submessage.
  struct EndpointPair {
    EntityId from, to;
  };
  template <class S>
  static EndpointPair endpoints_of(const S& submessage) {
    if constexpr (requires { submessage.missing; })
      return {submessage.reader, submessage.writer};
    else
      return {submessage.writer, submessage.reader};
  }

  template <class S>
  void put(const Destination& to, const InfoTimestamp* time, const S& submessage) {
    put(to, time, submessage, endpoints_of(submessage).from);
  }
  /// Adds the submessage, protected as one that `as` sends.
  template <class S>
  void put(const Destination& to, const InfoTimestamp* time, const S& submessage,
           const EntityId& as) {
    const auto endpoints = endpoints_of(submessage);
    const auto levels = protection_ ? protection_->levels(as) : SendProtection::Levels{};
    for (int attempt = 0; attempt < 2; ++attempt) {
      begin(to, levels);
      const auto before = out_.size();
      if (time != nullptr) write(out_, *time);
      if (!write_protected(levels, {to.prefix, endpoints.to}, endpoints.from, submessage)) {
        out_.rewind(before);
        return;
      }
      if (!out_.overflowed()) return;
      out_.rewind(before);
      finish_message();
    }
  }
  /// Returns false if the submessage could not be protected.
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
    // Submessages of this writer contain keys.
    if (sender == kVolatileMessageWriter) wipe(MutableBytes(plain_).first(plain.size()));
    return done;
  }
  std::optional<BytesView> protected_payload(const EntityId& writer, BytesView plain);
  bool write_protected_submessage(const EntityId& sender, const Guid& receiver, BytesView plain);
  void begin(const Destination& to, const SendProtection::Levels& levels);
  void begin_message(std::span<const Locator> to, const SendProtection::Levels& levels);
  /// Makes the message wait for a flush, or until kMaxWaiting messages wait.
  void finish_message();
  void wait_for_more(BytesView message);
  void send_waiting();
  void send_limited(const OutgoingMessages& out);
  MutableBytes slot(std::size_t index);

  Transport& transport_;
  Header header_;
  SendProtection* protection_ = nullptr;
  Bytes buffer_, payload_, plain_;
  std::array<Bytes, kMaxWaiting> slots_;  ///< the messages in the form in which they are sent
  std::array<BytesView, kMaxWaiting> messages_;  ///< the messages that wait
  std::size_t waiting_ = 0;
  std::size_t waiting_octets_ = 0;
  std::size_t slot_size_ = kMaxMessage;
  std::size_t full_size_ = kMaxMessage;
  SpanWriter out_;  ///< the current message, written into the next slot or protected into it
  std::vector<Locator> to_;  ///< the destination of everything that waits
  std::uint8_t dscp_ = 0;    ///< DSCP of everything that waits
  std::size_t interface_ = kEveryInterface;
  GuidPrefix destination_;  ///< destination of the last submessage
  GuidPrefix receiver_;     ///< receiver of all submessages in the message; zero if they differ
  /// Participant whose limit is charged for what waits; zero if there is none.
  GuidPrefix limited_;
  AmplificationLimit limit_;
  SendProtection::Wrap wrap_ = SendProtection::Wrap::none;
  bool may_delay_flush_ = false;
  MonotonicTime flush_by_ = kNever;
  int gatherings_ = 0;
  bool is_flush_wanted_ = false;
  std::uint32_t samples_heard_ = 0;
  std::uint16_t fragment_size_ = kMaxFragment;
};

}  // namespace ddssec::rtps
