#include "rtps/participant/liveliness_signal.hpp"

#include "rtps/participant/endpoint_listener.hpp"

namespace ddssec::rtps {

void LivelinessSignal::assert_at(MonotonicTime now) {
  latest_ = now;
  for (const auto& [reader, writer] : std::exchange(waiting_, {})) reader->on_alive(writer);
}

}  // namespace ddssec::rtps
