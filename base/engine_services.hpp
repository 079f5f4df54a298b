// The services that every engine gets from its host.
#pragma once

#include "base/clock.hpp"
#include "base/event.hpp"

namespace ddssec {

class DocumentsInUse;

/// Every engine gets them at construction. All of them must outlive it.
struct EngineServices {
  const Clock& clock;
  Random& random;
  EventSink& events;
  DocumentsInUse* documents = nullptr;  ///< where the engine notes its documents; null: nowhere
};

}  // namespace ddssec
