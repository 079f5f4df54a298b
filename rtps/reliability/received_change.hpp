// The change that a DATA or DATA_FRAG submessage carries.
#pragma once

#include "rtps/reliability/change.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {

/// With a copy of the payload.
Change received_change(const GuidPrefix& from, const Data& data, const std::optional<Time>& time);
/// With room for the payload of the whole sample.
Change received_change(const GuidPrefix& from, const DataFrag& frag,
                       const std::optional<Time>& time);

}  // namespace ddssec::rtps
