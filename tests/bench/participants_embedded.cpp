// The measuring peer on the embedded participant: role matched alone, as ddssec-peer has the
// others.
#include "bench/participants.h"
#include "peer_types.hpp"
#include "secured/participant.hpp"

namespace {

using namespace ddssec;
using peer::Blob;

struct Embedded {
  rtps::DataWriter<Blob>* writer = nullptr;
  rtps::DataReader<Blob>* reader = nullptr;

  static std::uint32_t readers(void* self) {
    const auto status = static_cast<Embedded*>(self)->writer->publication_matched_status();
    return static_cast<std::uint32_t>(status.current_count);
  }
  static std::uint32_t writers(void* self) {
    const auto status = static_cast<Embedded*>(self)->reader->subscription_matched_status();
    return static_cast<std::uint32_t>(status.current_count);
  }
};

Result<Embedded> create(rtps::DomainParticipant& participant, bench_role role) {
  DDSSEC_ASSIGN_OR_RETURN(const auto topic, participant.create_topic<Blob>(bench_written(role)));
  auto& written = *topic;
  DDSSEC_ASSIGN_OR_RETURN(const auto created_publisher, participant.create_publisher());
  auto& publisher = *created_publisher;
  DDSSEC_ASSIGN_OR_RETURN(const auto created_subscriber, participant.create_subscriber());
  auto& subscriber = *created_subscriber;
  auto reliable = rtps::default_reader_qos();
  reliable.reliability.kind = rtps::ReliabilityKind::reliable;
  DDSSEC_ASSIGN_OR_RETURN(const auto datawriter, publisher.create_datawriter<Blob>(written));
  DDSSEC_ASSIGN_OR_RETURN(const auto datareader,
                          subscriber.create_datareader<Blob>(written, reliable));
  return Embedded{datawriter, datareader};
}

int run(const bench_options& options) {
  const SystemClock clock;
  SystemRandom random;
  secured::StandardErrorEvents log;
  RateLimitedSink events(log, clock);
  const Environment environment{clock, random, events};
  secured::Engines engines(environment);
  rtps::DomainParticipantOptions wanted{.domain_id = static_cast<DomainId>(options.domain),
                                        .interfaces = {options.address},
                                        .multicast = true,
                                        .peers = {},
                                        .announce_types = false};
  if (options.security != nullptr)
    wanted.security.emplace(engines.view(),
                            secured::or_exit(secured::folder_properties(options.security)));
  auto participant = rtps::DomainParticipant::create(std::move(wanted), environment);
  if (!participant) return bench_refused("participant", participant.error().to_sentence().c_str());
  auto embedded = create(**participant, options.role);
  if (!embedded) return bench_refused("endpoint", embedded.error().to_sentence().c_str());
  const bench_stack stack = {
      &*embedded, Embedded::readers, Embedded::writers, nullptr, nullptr, nullptr, nullptr};
  return bench_run(&options, &stack);
}

}  // namespace

int main(int argc, char** argv) {
  bench_options options;
  bench_parse(argc, argv, &options);
  if (options.role == BENCH_MATCHED) return run(options);
  std::fputs("bench_embedded_peer: ddssec-peer has the other roles\n", stderr);
  return BENCH_USAGE;
}
