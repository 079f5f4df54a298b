// An event sink that ignores all events.
#pragma once

#include "base/event.hpp"

namespace ddssec::test {

struct Silent final : EventSink {
  void raise(const Event&) override {}
};

}  // namespace ddssec::test
