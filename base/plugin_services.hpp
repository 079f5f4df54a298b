// The services that every engine gets from its host.
#pragma once

#include "base/clock.hpp"
#include "base/event.hpp"

namespace ddssec {

class DocumentsInUse;

/// The services that an engine gets at construction. All of them must outlive it.
struct PluginServices {
  const Clock& clock;
  Random& random;
  EventSink& events;
  DocumentsInUse* documents = nullptr;  ///< the record of the engine's documents, or null
};

}  // namespace ddssec
