// An insider that announces endpoints of others as its own.
#pragma once

#include <functional>

#include "base/bytes.hpp"
#include "base/ids.hpp"

namespace ddssec::rtps::sim {

/// Replaces the name of the endpoint, in submessages that announce one, by what `other` returns.
/// `other` gets true for the name of a writer. The rest of the announcement stays as it is.
void claim(Bytes& submessages, const std::function<Guid(bool)>& other);

}  // namespace ddssec::rtps::sim
