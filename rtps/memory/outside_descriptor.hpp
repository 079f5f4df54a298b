// Descriptors that come from other processes and are not what was asked for.
#pragma once

#include "base/descriptor.hpp"

namespace ddssec::rtps::memory {

/// To close a descriptor can take as long as another process likes: a file of FUSE, for example. So
/// one thread of the process closes them, which starts when it is needed. If too many wait for it,
/// the descriptor stays open. Never blocks.
void close_elsewhere(Descriptor descriptor);
/// So many wait that no process should be asked for another one.
bool closes_too_many();

}  // namespace ddssec::rtps::memory
