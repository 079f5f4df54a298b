// Publishes a temperature ten times a second. The domain is 0 unless DOMAIN is given. All
// interfaces are used unless INTERFACE is given.
// Usage: publisher FOLDER [DOMAIN [INTERFACE]]
#include <cmath>
#include <secured/participant.hpp>
#include <string>
#include <thread>
#include <vector>

#include "reading.hpp"

using ddssec::secured::or_exit;
using ddssec::secured::Participant;

int main(int argc, char** argv) {
  const char* folder = argc > 1 ? argv[1] : "demo/talker";
  const int domain = argc > 2 ? std::stoi(argv[2]) : 0;
  // No interfaces means every interface that is up and does multicast.
  std::vector<std::string> interfaces;
  if (argc > 3) interfaces = {argv[3]};

  auto participant =
      or_exit(Participant::join(folder, {.domain_id = domain, .interfaces = interfaces}));
  auto* readings = or_exit(participant.create_writer<Reading>("Temperature"));

  for (int i = 0;; ++i) {
    or_exit(readings->write({.sensor = "kitchen", .celsius = 21 + std::sin(0.1 * i)}));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}
