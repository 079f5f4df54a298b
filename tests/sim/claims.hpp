// An insider that announces endpoints of others as its own.
#pragma once

#include <functional>

#include "base/bytes.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps::sim {

/// In submessages that announce an endpoint, its name becomes what `other` returns, which is asked
/// with true for that of a writer. Otherwise the announcement stays as it is.
void claim(Bytes& submessages, const std::function<Guid(bool)>& other);

}  // namespace ddssec::rtps::sim
