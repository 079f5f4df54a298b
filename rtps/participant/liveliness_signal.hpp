// When the writers of one remote participant with one LIVELINESS kind were asserted last.
#pragma once

#include <set>
#include <utility>

#include "base/clock.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps {

class EndpointListener;

/// An assertion costs the same however many writers there are: it is one time that all of their
/// readers look at when a lease seems to end. A reader is called only for a writer whose lease did
/// end, with the next assertion.
class LivelinessSignal {
 public:
  explicit LivelinessSignal(MonotonicTime now) : latest_(now) {}

  MonotonicTime latest() const { return latest_; }
  /// Calls EndpointListener::on_alive for all that wait.
  void assert_at(MonotonicTime now);
  /// `reader` is called with the next assertion, once for each writer that it names.
  void notify(EndpointListener& reader, const Guid& writer) { waiting_.insert({&reader, writer}); }
  void forget(EndpointListener& reader, const Guid& writer) { waiting_.erase({&reader, writer}); }

 private:
  MonotonicTime latest_;
  std::set<std::pair<EndpointListener*, Guid>> waiting_;
};

}  // namespace ddssec::rtps
