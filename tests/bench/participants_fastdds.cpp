// The measuring peer on Fast DDS 2.9 with its own plugins.
#include <cstdlib>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <memory>
#include <string>
#include <vector>

#include "bench/participants.h"

namespace fdds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::Duration_t;

namespace {

/// As received; to be sent it borrows its octets.
struct Blob {
  uint32_t seq = 0, pad = 0;
  uint64_t t_ns = 0;
  std::vector<uint8_t> data;
  const uint8_t* borrowed = nullptr;
  uint32_t length = 0;
};

// blob.idl in XCDR1, by hand: Debian has no Fast DDS code generator.
class BlobType : public fdds::TopicDataType {
 public:
  static constexpr uint32_t kOverhead = 4 + 4 + 4 + 8 + 4 + 4;

  explicit BlobType(uint32_t size) {
    setName("Blob");
    m_typeSize = kOverhead + size;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const Blob& blob = *static_cast<Blob*>(data);
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    payload->encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
    try {
      cdr.serialize_encapsulation();
      cdr << blob.seq << blob.pad << blob.t_ns << blob.length;
      cdr.serializeArray(blob.borrowed, blob.length);
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    payload->length = static_cast<uint32_t>(cdr.getSerializedDataLength());
    return true;
  }

  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    Blob& blob = *static_cast<Blob*>(data);
    FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    try {
      cdr.read_encapsulation();
      cdr >> blob.seq >> blob.pad >> blob.t_ns >> blob.data;
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    return true;
  }

  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [blob = static_cast<Blob*>(data)] { return kOverhead + blob->length; };
  }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
  void* createData() override { return new Blob; }
  void deleteData(void* data) override { delete static_cast<Blob*>(data); }
};

struct Fast {
  fdds::DataWriter* writer = nullptr;
  fdds::DataReader* reader = nullptr;
  Blob sent, received;
  bench_stack stack{};
};

Fast& fast(void* self) { return *static_cast<Fast*>(self); }

uint32_t readers(void* self) {
  fdds::PublicationMatchedStatus status;
  fast(self).writer->get_publication_matched_status(status);
  return static_cast<uint32_t>(status.current_count);
}

uint32_t writers(void* self) {
  fdds::SubscriptionMatchedStatus status;
  fast(self).reader->get_subscription_matched_status(status);
  return static_cast<uint32_t>(status.current_count);
}

bool write_blob(void* self, const bench_blob* blob) {
  Blob& sent = fast(self).sent;
  sent.seq = blob->seq;
  sent.pad = blob->pad;
  sent.t_ns = blob->t_ns;
  sent.borrowed = blob->data;
  sent.length = blob->length;
  return fast(self).writer->write(&sent);
}

bool take_blob(void* self, bench_blob* blob) {
  Blob& got = fast(self).received;
  fdds::SampleInfo info;
  while (fast(self).reader->take_next_sample(&got, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    *blob = {got.seq, got.pad, got.t_ns, got.data.data(), static_cast<uint32_t>(got.data.size())};
    return true;
  }
  return false;
}

void wait_for_data(void* self) {
  fast(self).reader->wait_for_unread_message(Duration_t(0, 20'000'000));
}

bool acknowledged(void* self) {
  return fast(self).writer->wait_for_acknowledgments(Duration_t(0, 10'000'000)) ==
         ReturnCode_t::RETCODE_OK;
}

class Echo : public fdds::DataReaderListener {
 public:
  explicit Echo(Fast& made) : made_(made) {}
  void on_data_available(fdds::DataReader*) override { bench_echo(&made_.stack); }

 private:
  Fast& made_;
};

// ---- set-up ---------------------------------------------------------------------------------

void set_security(fdds::DomainParticipantQos& qos, const char* folder) {
  auto set = [&](const std::string& name, const std::string& value) {
    qos.properties().properties().emplace_back(name, value);
  };
  auto document = [&](const std::string& property, const char* name) {
    const std::unique_ptr<char, decltype(&std::free)> uri(bench_document("file://", folder, name),
                                                          &std::free);
    set(property, uri.get());
  };
  const std::string auth = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  set("dds.sec.auth.plugin", "builtin.PKI-DH");
  set("dds.sec.access.plugin", "builtin.Access-Permissions");
  set("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
  document(auth + "identity_ca", "identity_ca.pem");
  document(auth + "identity_certificate", "cert.pem");
  document(auth + "private_key", "key.pem");
  document(access + "permissions_ca", "permissions_ca.pem");
  document(access + "governance", "governance.p7s");
  document(access + "permissions", "permissions.p7s");
}

// Loopback UDP alone.
void set_loopback(fdds::DomainParticipantQos& qos) {
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  udp->sendBufferSize = udp->receiveBufferSize = 4 << 20;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
}

// Unicast: a metatraffic locator with port 0 keeps Fast DDS off multicast.
void set_unicast(fdds::DomainParticipantQos& qos) {
  rtps::Locator_t loopback;
  rtps::IPLocator::setIPv4(loopback, "127.0.0.1");
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(loopback);
  builtin.initialPeersList.push_back(loopback);
  auto& discovery = builtin.discovery_config;
  discovery.leaseDuration_announcementperiod = Duration_t(0, 500'000'000);
  discovery.initial_announcements.period = Duration_t(0, 100'000'000);
}

void log_to_stderr() {
  auto consumer = std::make_unique<fdds::StdoutErrConsumer>();
  consumer->stderr_threshold(fdds::Log::Kind::Info);
  fdds::Log::ClearConsumers();
  fdds::Log::RegisterConsumer(std::move(consumer));
  fdds::Log::SetVerbosity(fdds::Log::Kind::Error);
}

template <class Qos>
void set_endpoint(Qos& qos, const bench_options& options) {
  qos.reliability().kind = fdds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = Duration_t(1, 0);
  qos.durability().kind = fdds::VOLATILE_DURABILITY_QOS;
  qos.history().kind = fdds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = static_cast<int32_t>(bench_most_samples(&options));
  qos.resource_limits().max_samples_per_instance = qos.resource_limits().max_samples;
  qos.resource_limits().allocated_samples = 16;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
}

bool create_endpoints(fdds::DomainParticipant& participant, fdds::TypeSupport& type,
                      const bench_options& options, Fast& made, fdds::DataReaderListener* echo) {
  const auto topic = [&](const char* name) {
    auto* known = dynamic_cast<fdds::Topic*>(participant.lookup_topicdescription(name));
    return known ? known
                 : participant.create_topic(name, type.get_type_name(), fdds::TOPIC_QOS_DEFAULT);
  };
  if (const char* written = bench_written(options.role)) {
    auto* publisher = participant.create_publisher(fdds::PUBLISHER_QOS_DEFAULT);
    auto* on = topic(written);
    fdds::DataWriterQos qos = fdds::DATAWRITER_QOS_DEFAULT;
    set_endpoint(qos, options);
    qos.reliable_writer_qos().times.heartbeatPeriod = Duration_t(0, 100'000'000);
    if (publisher && on) made.writer = publisher->create_datawriter(on, qos);
    if (!made.writer) return false;
  }
  if (const char* read = bench_read(options.role)) {
    auto* subscriber = participant.create_subscriber(fdds::SUBSCRIBER_QOS_DEFAULT);
    auto* on = topic(read);
    fdds::DataReaderQos qos = fdds::DATAREADER_QOS_DEFAULT;
    set_endpoint(qos, options);
    if (subscriber && on) made.reader = subscriber->create_datareader(on, qos, echo);
    if (!made.reader) return false;
  }
  return true;
}

int use(fdds::DomainParticipant& participant, const bench_options& options) {
  fdds::TypeSupport type(new BlobType(options.size));
  if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK)
    return bench_refused("type", "register_type failed");
  Fast made;
  made.stack = {&made, readers, writers, write_blob, take_blob, wait_for_data, acknowledged};
  Echo echo(made);
  if (!create_endpoints(participant, type, options, made,
                        options.role == BENCH_PONG ? &echo : nullptr))
    return bench_refused("endpoint", "Fast DDS gives no reason");
  const int code = bench_run(&options, &made.stack);
  if (made.reader) made.reader->set_listener(nullptr);
  return code;
}

int run(const bench_options& options) {
  fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
  set_loopback(qos);
  if (options.role != BENCH_MATCHED) set_unicast(qos);
  if (options.security) set_security(qos, options.security);
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  auto* participant = factory->create_participant(static_cast<uint32_t>(options.domain), qos);
  if (!participant) return bench_refused("participant", "Fast DDS gives no reason");
  const int code = use(*participant, options);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  bench_options options;
  bench_parse(argc, argv, &options);
  log_to_stderr();
  const int code = run(options);
  fdds::Log::Flush();
  return code;
}
