// The measuring peer on Fast DDS with its own plugins.
#include <cstdlib>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <memory>
#include <string>
#include <vector>

#include "bench/participants.h"
#include "interop/peers/fastdds_api.hpp"

namespace {

using namespace interop_fast;

// A received sample owns its octets. One that is sent borrows them.
struct Blob {
  uint32_t seq = 0, pad = 0;
  uint64_t t_ns = 0;
  std::vector<uint8_t> data;
  const uint8_t* borrowed = nullptr;
  uint32_t length = 0;
};

// The type of blob.idl.
class BlobType final : public TypeOf<Blob> {
 public:
  static constexpr std::uint32_t kOverhead = 4 + 4 + 4 + 8 + 4 + 4;

  explicit BlobType(std::uint32_t size) : TypeOf("Blob", kOverhead + size, false) {}

 private:
  void write(Cdr& cdr, const void* sample) const override {
    const auto& blob = *static_cast<const Blob*>(sample);
    cdr << blob.seq << blob.pad << blob.t_ns << blob.length;
    write_octets(cdr, blob.borrowed, blob.length);
  }
  void read(Cdr& cdr, void* sample) const override {
    auto& blob = *static_cast<Blob*>(sample);
    cdr >> blob.seq >> blob.pad >> blob.t_ns >> blob.data;
  }
  std::uint32_t most_octets(const void* sample) const override {
    return kOverhead + static_cast<const Blob*>(sample)->length;
  }
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
  return ok(fast(self).writer->write(&sent));
}

bool take_blob(void* self, bench_blob* blob) {
  Blob& got = fast(self).received;
  fdds::SampleInfo info;
  while (ok(fast(self).reader->take_next_sample(&got, &info))) {
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
  return ok(fast(self).writer->wait_for_acknowledgments(Duration_t(0, 10'000'000)));
}

class Echo : public fdds::DataReaderListener {
 public:
  explicit Echo(Fast& made) : made_(made) {}
  void on_data_available(fdds::DataReader*) override { bench_on_data(&made_.stack); }

 private:
  Fast& made_;
};

// ---- set-up

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

template <class Qos>
void set_endpoint(Qos& qos, const bench_options& options) {
  qos.reliability().kind =
      options.best_effort ? fdds::BEST_EFFORT_RELIABILITY_QOS : fdds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = Duration_t(1, 0);
  qos.durability().kind = fdds::VOLATILE_DURABILITY_QOS;
  qos.history().kind =
      options.best_effort ? fdds::KEEP_LAST_HISTORY_QOS : fdds::KEEP_ALL_HISTORY_QOS;
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
    set_heartbeat_period(qos, Duration_t(0, 100'000'000));
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
  if (!ok(type.register_type(&participant))) return bench_refused("type", "register_type failed");
  Fast made;
  made.stack = {&made, readers, writers, write_blob, take_blob, wait_for_data, acknowledged};
  Echo echo(made);
  if (!create_endpoints(participant, type, options, made,
                        bench_listens(&options) ? &echo : nullptr))
    return bench_refused("endpoint", "Fast DDS gives no reason");
  const int code = bench_run(&options, &made.stack);
  if (made.reader) made.reader->set_listener(nullptr);
  return code;
}

int run(const bench_options& options) {
  fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
  constexpr const char* kLoopback = "127.0.0.1";
  const auto udp = use_udp_alone(qos, kLoopback);
  udp->sendBufferSize = udp->receiveBufferSize = 4 << 20;
  if (options.role != BENCH_MATCHED) use_unicast_alone(qos, kLoopback, kLoopback);
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
  log_to_stderr(fdds::Log::Kind::Error);
  const int code = run(options);
  fdds::Log::Flush();
  return code;
}
