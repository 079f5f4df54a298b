// The services that every plugin gets from its host.
#pragma once

#include "base/clock.hpp"
#include "base/event.hpp"

namespace ddssec {

class DocumentsInUse;

/// The services that a plugin gets at construction. All of them must outlive it.
struct PluginServices {
  const Clock& clock;
  Random& random;
  EventSink& events;
  DocumentsInUse* documents = nullptr;  ///< the record of the plugin's documents, or null
};

}  // namespace ddssec
