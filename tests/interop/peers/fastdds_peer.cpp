// Test peer on Fast DDS, with the same command line and output as the Cyclone peer, and --version.
// Fast DDS has its security plugins compiled in, so it is always a stock peer.
#include <cstdio>
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "interop/peers/fastdds_shape.hpp"
#include "interop/peers/peer.h"

namespace {

using namespace interop_fast;

class AuthenticationWatch : public fdds::DomainParticipantListener {
 public:
  void onParticipantAuthentication(fdds::DomainParticipant*,
                                   rtps::ParticipantAuthenticationInfo&& info) override {
    const bool good = info.status == rtps::ParticipantAuthenticationInfo::AUTHORIZED_PARTICIPANT;
    peer_say(good ? "authorized" : "unauthorized");
  }
};

struct Fast {
  fdds::DataWriter* writer = nullptr;
  fdds::DataReader* reader = nullptr;
  Shape received;
};

Fast& fast(void* self) { return *static_cast<Fast*>(self); }

uint32_t matched(void* self) {
  fdds::PublicationMatchedStatus published;
  fdds::SubscriptionMatchedStatus subscribed;
  if (fast(self).writer) {
    fast(self).writer->get_publication_matched_status(published);
    return static_cast<uint32_t>(published.current_count);
  }
  fast(self).reader->get_subscription_matched_status(subscribed);
  return static_cast<uint32_t>(subscribed.current_count);
}

bool write_sample(void* self, int32_t index, const uint8_t* payload, uint32_t length) {
  Shape shape{.x = index, .y = 2 * index, .payload = {payload, payload + length}};
  return ok(fast(self).writer->write(&shape));
}

bool acknowledged(void* self) {
  return ok(fast(self).writer->wait_for_acknowledgments(Duration_t(0, 5'000'000)));
}

bool take_sample(void* self, peer_sample* sample) {
  Shape& shape = fast(self).received;
  fdds::SampleInfo info;
  while (ok(fast(self).reader->take_next_sample(&shape, &info))) {
    if (!info.valid_data) continue;
    *sample = {shape.color.c_str(), shape.x, shape.payload.data(),
               static_cast<uint32_t>(shape.payload.size())};
    return true;
  }
  return false;
}

// ---- set-up

void set_security(fdds::DomainParticipantQos& qos, const peer_options& options) {
  auto set = [&](const std::string& name, const std::string& value) {
    qos.properties().properties().emplace_back(name, value);
  };
  auto document = [&](const std::string& name, peer_security which) {
    if (!options.security[which]) return;
    const std::unique_ptr<char, decltype(&std::free)> uri(
        peer_uri("file://", options.security[which]), &std::free);
    set(name, uri.get());
  };
  const std::string auth = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  set("dds.sec.auth.plugin", "builtin.PKI-DH");
  set("dds.sec.access.plugin", "builtin.Access-Permissions");
  set("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  document(auth + "identity_ca", PEER_IDENTITY_CA);
  document(auth + "identity_certificate", PEER_IDENTITY_CERTIFICATE);
  document(auth + "private_key", PEER_PRIVATE_KEY);
  document(auth + "identity_crl", PEER_CRL);
  document(access + "permissions_ca", PEER_PERMISSIONS_CA);
  document(access + "governance", PEER_GOVERNANCE);
  document(access + "permissions", PEER_PERMISSIONS);
  if (options.security[PEER_PASSWORD]) set(auth + "password", options.security[PEER_PASSWORD]);
  if (options.security[PEER_KEYSIZE]) set("dds.sec.crypto.keysize", options.security[PEER_KEYSIZE]);
}

template <class Qos>
void set_reliable(Qos& qos, const peer_options& options) {
  qos.reliability().kind = fdds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind =
      options.is_volatile ? fdds::VOLATILE_DURABILITY_QOS : fdds::TRANSIENT_LOCAL_DURABILITY_QOS;
  qos.history().kind = fdds::KEEP_ALL_HISTORY_QOS;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
}

bool create_writer(fdds::DomainParticipant& participant, fdds::Topic* topic,
                   const peer_options& options, Fast& made) {
  fdds::PublisherQos group = fdds::PUBLISHER_QOS_DEFAULT;
  if (options.partition) group.partition().push_back(options.partition);
  fdds::Publisher* publisher = participant.create_publisher(group);
  if (!publisher) return false;
  fdds::DataWriterQos qos = fdds::DATAWRITER_QOS_DEFAULT;
  set_reliable(qos, options);
  if (options.keep_last > 0) {
    qos.history().kind = fdds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = static_cast<int32_t>(options.keep_last);
  }
  set_heartbeat_period(qos, Duration_t(0, 100'000'000));
  made.writer = publisher->create_datawriter(topic, qos);
  return made.writer != nullptr;
}

bool create_reader(fdds::DomainParticipant& participant, fdds::Topic* topic,
                   const peer_options& options, Fast& made) {
  fdds::SubscriberQos group = fdds::SUBSCRIBER_QOS_DEFAULT;
  if (options.partition) group.partition().push_back(options.partition);
  fdds::Subscriber* subscriber = participant.create_subscriber(group);
  if (!subscriber) return false;
  fdds::DataReaderQos qos = fdds::DATAREADER_QOS_DEFAULT;
  set_reliable(qos, options);
  made.reader = subscriber->create_datareader(topic, qos);
  return made.reader != nullptr;
}

int use(fdds::DomainParticipant& participant, const peer_options& options) {
  fdds::TypeSupport type(new ShapeType);
  if (!ok(type.register_type(&participant))) return peer_refused("type", "register_type failed");
  fdds::Topic* topic =
      participant.create_topic(options.topic, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT);
  if (!topic) return peer_refused("topic", "create_topic failed");
  Fast made;
  const bool created = options.publish ? create_writer(participant, topic, options, made)
                                       : create_reader(participant, topic, options, made);
  if (!created) return peer_refused("endpoint", "Fast DDS gives no reason");
  const peer_stack stack{&made, matched, write_sample, acknowledged, take_sample};
  return peer_run(&options, &stack);
}

int run(const peer_options& options) {
  fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
  set_interface(qos, options.address, options.peer);
  if (options.lease > 0)
    qos.wire_protocol().builtin.discovery_config.leaseDuration =
        Duration_t(static_cast<int32_t>(options.lease), 0);
  if (!options.plain) set_security(qos, options);
  for (std::size_t i = 0; i < options.properties; ++i)
    qos.properties().properties().emplace_back(options.property_name[i], options.property_value[i]);
  AuthenticationWatch watch;
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  fdds::DomainParticipant* participant =
      factory->create_participant(options.domain, qos, &watch, fdds::StatusMask::none());
  if (!participant) return peer_refused("participant", "Fast DDS gives no reason");
  const int status = use(*participant, options);
  participant->set_listener(nullptr);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--version") {
    std::printf("%d\n", DDSSEC_FASTDDS);
    return 0;
  }
  peer_options options;
  peer_parse(argc, argv, &options);
  log_to_stderr();
  const int status = run(options);
  fdds::Log::Flush();
  return status;
}
