// The time of the last assertion of one remote participant's writers of one LIVELINESS kind.
#pragma once

#include <set>
#include <utility>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

class EndpointListener;

/// An assertion costs the same for any number of writers: it stores one time, which all of their
/// readers check when a lease seems to end. A reader is called only for a writer whose lease did
/// end, at the next assertion.
class LivelinessSignal {
 public:
  explicit LivelinessSignal(MonotonicTime now) : latest_(now) {}

  MonotonicTime latest() const { return latest_; }
  /// Calls EndpointListener::on_alive for all readers that wait.
  void assert_at(MonotonicTime now);
  /// Registers `reader` to be called at the next assertion, once for each writer that it registers.
  void notify(EndpointListener& reader, const Guid& writer) { waiting_.insert({&reader, writer}); }
  void forget(EndpointListener& reader, const Guid& writer) { waiting_.erase({&reader, writer}); }

 private:
  MonotonicTime latest_;
  std::set<std::pair<EndpointListener*, Guid>> waiting_;
};

}  // namespace ddssec::rtps
