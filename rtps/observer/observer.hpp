// Collects what a passive listener learns about secured participants: their announcements, the
// progress of handshakes, and what is sent unprotected. None of this is proven: any host may have
// sent it in any name. No I/O, clock or lock.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <set>

#include "base/clock.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "rtps/security/fragment_store.hpp"
#include "wire/data.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::rtps {

struct EndpointData;

/// The number of times that something was seen, and when.
struct Sightings {
  std::uint64_t count = 0;
  MonotonicTime first{}, last{};
  explicit operator bool() const { return count > 0; }
  void note(MonotonicTime at);
};

/// The steps by which two participants come to trust each other, in this order (DDS-Security 1.2,
/// clause 9.8).
enum class HandshakeStep : std::uint8_t {
  auth_request,
  request,
  reply,
  final,
  keys,  ///< protected submessages for the other participant; the first ones carry keys
};
std::string_view to_string(HandshakeStep step);

/// The messages that one participant sent to another one.
struct HandshakeFlow {
  std::array<Sightings, 5> steps = {};
  Sightings& at(HandshakeStep step) { return steps[static_cast<std::size_t>(step)]; }
  const Sightings& at(HandshakeStep step) const { return steps[static_cast<std::size_t>(step)]; }
};

/// The names in a certificate.
struct CertificateNames {
  std::string subject, issuer;
};
/// Reads a certificate in PEM; empty if it is not one. (This folder does not depend on the
/// certificate code.)
using ReadCertificate = std::function<std::optional<CertificateNames>(BytesView pem)>;

/// A topic that plain discovery announced for a participant.
struct ObservedTopic {
  std::string type;
  bool is_written = false, is_read = false;
  std::size_t octets = 0;  ///< octets that it counts for the limit
};

/// What was heard of one participant. Nothing of it is proven: any sender can claim it.
struct ObservedParticipant {
  /// Its latest announcement; empty if it never announced itself.
  std::optional<ParticipantData> data;
  VendorId vendor;
  DomainId domain = -1;             ///< -1 if no announcement names it
  std::set<std::string> addresses;  ///< addresses from which it was heard
  Sightings messages;
  std::uint64_t protected_messages = 0;
  std::uint64_t protected_submessages = 0;
  std::set<TransformKind> kinds;    ///< kinds of the protected messages and submessages
  std::uint64_t clear_samples = 0;  ///< samples of user topics
  /// Payloads of user topics, in submessages that are not protected.
  std::uint64_t encrypted_payloads = 0;
  /// The topics that plain discovery announced, by name.
  std::map<std::string, ObservedTopic> clear_topics;
  std::size_t topic_octets = 0;  ///< octets of these topics, including a price for each
  /// The names from its handshake messages, which are not encrypted.
  std::optional<CertificateNames> certificate;
  bool has_left = false;

  bool is_secured() const { return data && data->identity_token; }
};

/// Collects what the messages of a network reveal of the participants in it.
class Observer {
 public:
  /// The limits. Above them nothing new is stored, but what is stored is still counted.
  static constexpr std::size_t kMaxParticipants = 1024;
  static constexpr std::size_t kMaxFlows = 65536;
  static constexpr std::size_t kMaxTopicsEach = 4096;
  /// The limit for the topics of all participants together. Each participant keeps
  /// kTopicOctetsOfEach, whatever others announce.
  static constexpr std::size_t kMaxTopicOctets = std::size_t{32} << 20;
  static constexpr std::size_t kTopicOctetsOfEach = std::size_t{32} << 10;
  static constexpr std::size_t kPricePerTopic = 256;
  static constexpr std::size_t kMaxAddressesEach = 16;
  static constexpr std::size_t kMaxKindsEach = 16;

  explicit Observer(ReadCertificate read_certificate = {})
      : read_certificate_(std::move(read_certificate)) {}

  struct Arrival {
    std::string_view from;   ///< an address as text
    std::uint16_t port = 0;  ///< the destination port
    MonotonicTime at{};
  };
  /// Processes any datagram; one that is not RTPS is only counted.
  void on_datagram(BytesView datagram, const Arrival& arrival);

  using Participants = std::map<GuidPrefix, ObservedParticipant>;
  const Participants& participants() const { return participants_; }
  /// Returns the messages from the first participant to the second.
  const HandshakeFlow& flow(const GuidPrefix& from, const GuidPrefix& to) const;
  const Sightings& datagrams() const { return datagrams_; }
  std::uint64_t rtps_messages() const { return rtps_messages_; }
  /// Returns the number of messages of participants, and of topics, for which there was no room.
  std::uint64_t left_out() const { return left_out_; }

 private:
  struct Message {
    GuidPrefix source, destination;  ///< zero if it is for all
    ObservedParticipant* sender;
    const Arrival& arrival;
  };
  ObservedParticipant* find(const GuidPrefix& prefix);
  HandshakeFlow* flow_to(const Message& message, const GuidPrefix& to);
  void walk(MessageReader reader, Message& message);
  void on_submessage(const SubmessageView& view, Message& message);
  void on_source(const SubmessageView& view, Message& message);
  void on_data(const Data& data, const Message& message);
  void on_announcement(const Data& data, const Message& message);
  void on_topic(const Data& data, const Message& message);
  /// Returns the entry for the topic; nullptr if there is no room for it.
  ObservedTopic* topic_of(ObservedParticipant& sender, const EndpointData& endpoint);
  void on_stateless(BytesView payload, const Message& message);
  void on_protected(const SubmessageView& prefix, const Message& message);

  ReadCertificate read_certificate_;
  Participants participants_;
  std::map<std::pair<GuidPrefix, GuidPrefix>, HandshakeFlow> flows_;
  FragmentStore fragments_;
  Sightings datagrams_;
  std::uint64_t rtps_messages_ = 0;
  std::uint64_t left_out_ = 0;
  std::size_t topic_octets_ = 0;  ///< octets of the topics of all participants
};

}  // namespace ddssec::rtps
