// Creates the change that a DATA or DATA_FRAG submessage carries.
#pragma once

#include "rtps/reliability/change.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {

/// Returns the change of a DATA. `payload` is its payload, or one to which it refers.
Change received_change(const GuidPrefix& from, const Data& data, const std::optional<Time>& time,
                       Payload payload);
/// Returns the change of a DATA_FRAG. Its payload has the size of the whole sample.
Change received_change(const GuidPrefix& from, const DataFrag& frag,
                       const std::optional<Time>& time);

}  // namespace ddssec::rtps
