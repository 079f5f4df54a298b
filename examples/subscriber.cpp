// Prints temperatures as they arrive, and ends after ten seconds without one. The domain is 0
// unless DOMAIN is given. All interfaces are used unless INTERFACE is given.
// Usage: subscriber FOLDER [DOMAIN [INTERFACE]]
#include <cstdio>
#include <secured/participant.hpp>
#include <string>
#include <vector>

#include "reading.hpp"

using ddssec::secured::or_exit;
using ddssec::secured::Participant;

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // flush each line, even into a pipe
  const char* folder = argc > 1 ? argv[1] : "demo/listener";
  const int domain = argc > 2 ? std::stoi(argv[2]) : 0;
  // No interfaces means every interface that is up and does multicast.
  std::vector<std::string> interfaces;
  if (argc > 3) interfaces = {argv[3]};

  auto participant =
      or_exit(Participant::join(folder, {.domain_id = domain, .interfaces = interfaces}));
  auto* readings = or_exit(participant.create_reader<Reading>("Temperature"));

  while (readings->wait_for_unread(std::chrono::seconds(10)))
    while (const auto reading = readings->take_next_sample())
      if (reading->info.valid_data)
        std::printf("%s %.2f\n", reading->data.sensor.c_str(), reading->data.celsius);
}
