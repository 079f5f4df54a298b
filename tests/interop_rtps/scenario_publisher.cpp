// A publisher of shapes whose life changes while it runs, for scenario.py:
// scenario_publisher DOMAIN TOPIC SIZE STRENGTH [LEASE_MS]
// A number on standard input is its new OWNERSHIP_STRENGTH.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <shape.hpp>
#include <thread>

#include "rtps/dcps/domain_participant.hpp"
#include "tests/support/silent.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::rtps;

int publish(DomainParticipant& participant, char** argv, int argc) {
  auto* topic = *participant.create_topic<shapes::ShapeType>(argv[2]);
  Qos qos = default_writer_qos();
  qos.ownership = OwnershipKind::exclusive;
  qos.ownership_strength = std::atoi(argv[4]);
  qos.deadline = Duration::from(std::chrono::milliseconds(300));
  if (argc > 5)
    qos.liveliness.lease_duration = Duration::from(std::chrono::milliseconds(std::atoi(argv[5])));
  auto* publisher = &participant.create_publisher();
  auto* writer = *publisher->create_datawriter<shapes::ShapeType>(*topic, qos);
  std::atomic<int> wanted = qos.ownership_strength;
  std::thread listening([&wanted] {
    for (int strength = 0; std::scanf("%d", &strength) == 1;) wanted = strength;
  });
  listening.detach();
  for (shapes::ShapeType shape{"TRACK", 1, 2, std::atoi(argv[3]), {}};;
       std::this_thread::sleep_for(std::chrono::milliseconds(20))) {
    if (wanted != qos.ownership_strength) {
      qos.ownership_strength = wanted;
      if (!writer->set_qos(qos)) return 4;
    }
    if (!writer->write(shape)) return 5;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) return 1;
  const SystemClock clock;
  SystemRandom random;
  test::Silent events;
  auto participant =
      DomainParticipant::create({.domain_id = std::atoi(argv[1])}, {clock, random, events});
  if (!participant) return 3;
  return publish(**participant, argv, argc);
}
