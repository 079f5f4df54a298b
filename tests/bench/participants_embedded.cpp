// The measuring peer on the embedded participant, for the roles of participants.h that ddssec-peer
// lacks, or has in one form only.
#include "base/rate_limited_sink.hpp"
#include "bench/participants.h"
#include "peer_types.hpp"
#include "rtps/dcps/wait_set.hpp"
#include "secured/participant.hpp"
#include "secured/security_plugin_set.hpp"

namespace {

using namespace ddssec;
using peer::Blob;

struct Embedded final : rtps::DataReaderListener {
  rtps::DataWriter<Blob>* writer = nullptr;
  rtps::DataReader<Blob>* reader = nullptr;
  rtps::WaitSet unread;
  Blob sent;
  rtps::Samples<Blob> taken;
  bench_stack stack{};

  void on_data_available(rtps::AnyDataReader&) override { bench_on_data(&stack); }
};

Embedded& of(void* self) { return *static_cast<Embedded*>(self); }

std::uint32_t readers(void* self) {
  return static_cast<std::uint32_t>(of(self).writer->publication_matched_status().current_count);
}

std::uint32_t writers(void* self) {
  return static_cast<std::uint32_t>(of(self).reader->subscription_matched_status().current_count);
}

bool write_blob(void* self, const bench_blob* blob) {
  auto& sent = of(self).sent;
  sent.seq = blob->seq;
  sent.pad = blob->pad;
  sent.t_ns = blob->t_ns;
  sent.data.assign(blob->data, blob->data + blob->length);
  return of(self).writer->write(sent).has_value();
}

bool take_blob(void* self, bench_blob* blob) {
  auto& embedded = of(self);
  while (embedded.reader->take(embedded.taken, 1).value_or(0) == 1) {
    if (!embedded.taken[0].info.valid_data) continue;
    const auto& got = embedded.taken[0].data;
    *blob = {got.seq, got.pad, got.t_ns, got.data.data(),
             static_cast<std::uint32_t>(got.data.size())};
    return true;
  }
  return false;
}

void wait_for_data(void* self) { (void)of(self).unread.wait(std::chrono::milliseconds(20)); }

bool acknowledged(void* self) {
  return of(self).writer->wait_for_acknowledgments(std::chrono::milliseconds(10)).has_value();
}

template <class Writer>
rtps::Qos qos_of(const bench_options& options, rtps::Qos qos, Writer) {
  qos.reliability.kind =
      options.best_effort ? rtps::ReliabilityKind::best_effort : rtps::ReliabilityKind::reliable;
  if (options.best_effort || options.role == BENCH_MATCHED) return qos;
  qos.history.kind = rtps::HistoryKind::keep_all;
  if (Writer::value)
    qos.resource_limits.max_samples = static_cast<std::int32_t>(bench_most_samples(&options));
  return qos;
}

Result<rtps::Topic*> topic(rtps::DomainParticipant& participant, const char* name) {
  if (auto* known = participant.lookup_topicdescription(name)) return known;
  return participant.create_topic<Blob>(name);
}

Status create(rtps::DomainParticipant& participant, const bench_options& options,
              Embedded& embedded) {
  if (const char* written = bench_written(options.role)) {
    DDSSEC_ASSIGN_OR_RETURN(auto* const on, topic(participant, written));
    auto& publisher = participant.create_publisher();
    DDSSEC_ASSIGN_OR_RETURN(
        embedded.writer, publisher.create_datawriter<Blob>(
                             *on, qos_of(options, rtps::default_writer_qos(), std::true_type())));
  }
  if (const char* read = bench_read(options.role)) {
    DDSSEC_ASSIGN_OR_RETURN(auto* const on, topic(participant, read));
    auto& subscriber = participant.create_subscriber();
    DDSSEC_ASSIGN_OR_RETURN(embedded.reader,
                            subscriber.create_datareader<Blob>(
                                *on, qos_of(options, rtps::default_reader_qos(), std::false_type()),
                                bench_listens(&options) ? &embedded : nullptr));
    embedded.unread.attach_condition(
        embedded.reader->create_readcondition({.sample = rtps::SampleState::not_read}));
  }
  return {};
}

int run(const bench_options& options) {
  const SystemClock clock;
  SystemRandom random;
  secured::StandardErrorEvents log;
  RateLimitedSink events(log, clock);
  const PluginServices services{clock, random, events};
  secured::SecurityPluginSet plugins(services);
  const bool fleet = !bench_is_local(&options);
  rtps::DomainParticipantOptions wanted{.domain_id = static_cast<DomainId>(options.domain),
                                        .interfaces = {options.address},
                                        .multicast = fleet,
                                        .announce_types = false};
  wanted.busy_wait = std::chrono::microseconds(options.busy_wait_us);
  if (fleet) wanted.peers = {};
  if (options.security != nullptr)
    wanted.security.emplace(plugins.plugins(),
                            secured::or_exit(secured::folder_properties(options.security)));
  Embedded embedded;
  embedded.stack = {&embedded, readers,       writers,     write_blob,
                    take_blob, wait_for_data, acknowledged};
  auto participant = rtps::DomainParticipant::create(std::move(wanted), services);
  if (!participant) return bench_refused("participant", participant.error().to_sentence().c_str());
  if (const auto created = create(**participant, options, embedded); !created)
    return bench_refused("endpoint", created.error().to_sentence().c_str());
  const int code = bench_run(&options, &embedded.stack);
  participant->reset();
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  bench_options options;
  bench_parse(argc, argv, &options);
  return run(options);
}
