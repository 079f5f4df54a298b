// The embedded participant behind the command line of the interop peers.
#include <cstdlib>
#include <memory>
#include <string>

#include "base/rate_limited_sink.hpp"
#include "interop/peers/peer.h"
#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"
#include "rtps/dcps/domain_participant.hpp"

namespace ddssec::rtps {

struct Shape {
  std::string color;
  std::int32_t x = 0, y = 0, shapesize = 0;
  std::vector<std::uint8_t> payload;
};
template <>
struct TypeTraits<Shape> {
  static constexpr std::string_view type_name = "interop::Shape";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(key(s.color), s.x, s.y, s.shapesize, s.payload);
  }
};

namespace {

class StderrSink final : public EventSink {
 public:
  void raise(const Event& event) override { std::fprintf(stderr, "%s\n", event.to_line().c_str()); }
};

// A writer or a reader, with the calls of peer_stack as plain functions.
struct Embedded {
  DataWriter<Shape>* writer = nullptr;
  DataReader<Shape>* reader = nullptr;
  Sample<Shape> last;

  static Embedded& of(void* self) { return *static_cast<Embedded*>(self); }
  static std::uint32_t matched(void* self) {
    const auto& e = of(self);
    const auto status = e.writer != nullptr ? e.writer->publication_matched_status()
                                            : e.reader->subscription_matched_status();
    return static_cast<std::uint32_t>(status.current_count);
  }
  static bool write(void* self, std::int32_t index, const std::uint8_t* payload,
                    std::uint32_t length) {
    return of(self)
        .writer->write({"BLUE", index, 3 * index + 7, 30, {payload, payload + length}})
        .has_value();
  }
  static bool acknowledged(void* self) {
    return of(self).writer->wait_for_acknowledgments(std::chrono::milliseconds(5)).has_value();
  }
  static bool take(void* self, peer_sample* sample) {
    auto taken = of(self).reader->take_next_sample();
    while (taken && !taken->info.valid_data) taken = of(self).reader->take_next_sample();
    if (!taken) return false;
    of(self).last = std::move(*taken);
    const auto& data = of(self).last.data;
    *sample = {data.color.c_str(), data.x, data.payload.data(),
               static_cast<std::uint32_t>(data.payload.size())};
    return true;
  }
};

Qos qos_of(const peer_options& options) {
  auto qos = options.publish ? default_writer_qos() : default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  qos.durability =
      options.is_volatile ? DurabilityKind::volatile_ : DurabilityKind::transient_local;
  qos.history.kind = HistoryKind::keep_all;
  if (options.publish && options.keep_last > 0)
    qos.history = {HistoryKind::keep_last, static_cast<std::int32_t>(options.keep_last)};
  return qos;
}

// Creates the topic, the publisher or subscriber, and the endpoint.
Status create(DomainParticipant& participant, const peer_options& options, Embedded& out) {
  GroupQos group;
  if (options.partition != nullptr) group.partition = {options.partition};
  DDSSEC_ASSIGN_OR_RETURN(const auto shape, participant.create_topic<Shape>(options.topic));
  auto& topic = *shape;
  if (options.publish) {
    auto& publisher = participant.create_publisher(group);
    DDSSEC_ASSIGN_OR_RETURN(out.writer, publisher.create_datawriter<Shape>(topic, qos_of(options)));
  } else {
    auto& subscriber = participant.create_subscriber(group);
    DDSSEC_ASSIGN_OR_RETURN(out.reader,
                            subscriber.create_datareader<Shape>(topic, qos_of(options)));
  }
  return {};
}

// The three plugins of one process.
struct Plugins {
  explicit Plugins(const PluginServices& services)
      : authentication(authentication::make_authentication(services)),
        access_control(
            access_control::make_access_control(services, {.host_revises_keys = true,
                                                           .host_has_pre_shared_keys = true,
                                                           .host_changes_protection = true})),
        cryptography(cryptography::make_cryptography(services)) {}
  std::unique_ptr<spi::Authentication> authentication;
  std::unique_ptr<spi::AccessControl> access_control;
  std::unique_ptr<spi::Cryptography> cryptography;
};

struct Document {
  peer_security option;
  std::string_view property;
  bool is_file = true;
};

spi::PropertyList properties_of(const peer_options& options) {
  namespace property = spi::property;
  constexpr Document kDocuments[] = {
      {PEER_IDENTITY_CA, property::kIdentityCa},
      {PEER_IDENTITY_CERTIFICATE, property::kIdentityCertificate},
      {PEER_PRIVATE_KEY, property::kPrivateKey},
      {PEER_PASSWORD, property::kPassword, false},
      {PEER_CRL, property::kCrl},
      {PEER_PERMISSIONS_CA, property::kPermissionsCa},
      {PEER_GOVERNANCE, property::kGovernance},
      {PEER_PERMISSIONS, property::kPermissions},
      {PEER_KEYSIZE, property::kKeySize, false},
      {PEER_CIPHER, property::kSymmetricCipher, false},
  };
  spi::PropertyList out;
  for (const auto& [option, name, is_file] : kDocuments) {
    const char* value = options.security[option];
    if (value == nullptr) continue;
    const bool is_uri = !is_file || std::string_view(value).starts_with("data:");
    out.push_back({std::string(name), is_uri ? value : "file:" + std::string(value), false});
  }
  // The properties of the file count, as in our plugins in Cyclone DDS.
  if (const char* const file = std::getenv("DDSSEC_PROPERTIES")) {
    const auto properties = spi::read_property_file(file).value();
    out.insert(out.end(), properties.begin(), properties.end());
  }
  return out;
}

int run(const peer_options& options) {
  const SystemClock clock;
  SystemRandom random;
  StderrSink log;
  RateLimitedSink events(log, clock);
  const PluginServices services{clock, random, events};
  const Plugins plugins(services);
  DomainParticipantOptions wanted{.domain_id = static_cast<DomainId>(options.domain),
                                  .interfaces = {options.address},
                                  .multicast = false,
                                  .peers = {options.peer}};
  // The defaults count, as for a program that sets nothing about networks.
  if (options.address == std::string_view("default")) {
    const DomainParticipantOptions standard;
    wanted.interfaces = standard.interfaces;
    wanted.multicast = standard.multicast;
    wanted.peers = standard.peers;
  }
  if (options.lease > 0)
    wanted.lease_duration = Duration::from(std::chrono::seconds(options.lease));
  if (!options.plain)
    wanted.security.emplace(
        SecurityPlugins{*plugins.authentication, *plugins.access_control, *plugins.cryptography},
        properties_of(options));
  auto participant = DomainParticipant::create(std::move(wanted), services);
  if (!participant) return peer_refused("participant", participant.error().to_sentence().c_str());
  Embedded embedded;
  const auto created = create(**participant, options, embedded);
  if (!created) return peer_refused("endpoint", created.error().to_sentence().c_str());
  const peer_stack stack = {&embedded, Embedded::matched, Embedded::write, Embedded::acknowledged,
                            Embedded::take};
  return peer_run(&options, &stack);
}

}  // namespace
}  // namespace ddssec::rtps

int main(int argc, char** argv) {
  peer_options options;
  peer_parse(argc, argv, &options);
  return ddssec::rtps::run(options);
}
