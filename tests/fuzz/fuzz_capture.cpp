// A capture with any frames, each of which has two octets of length before it.
#include "rtps/observer/frames.hpp"
#include "rtps/observer/meetings.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  rtps::Frames frames;
  rtps::Observer observer;
  BytesView rest(data, size);
  for (std::chrono::nanoseconds now{}; rest.size() > 2; now += std::chrono::seconds(1)) {
    const auto length = std::min<std::size_t>(rest[0] | rest[1] << 8, rest.size() - 2);
    const auto frame = rest.subspan(2, length);
    observer.on_datagram(frame, {"127.0.0.1", 7400, now});
    if (const auto heard = frames.read(1, frame))
      observer.on_datagram(heard->payload, {heard->from, heard->port, now});
    rest = rest.subspan(2 + length);
  }
  meetings_of(observer);
  leaks_of(observer);
  return 0;
}
