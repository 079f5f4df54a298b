// Creates the change that a DATA or DATA_FRAG submessage carries.
#pragma once

#include "rtps/reliability/change.hpp"
#include "wire/data_frag.hpp"

namespace ddssec::rtps {

/// The payload is copied.
Change received_change(const GuidPrefix& from, const Data& data, const std::optional<Time>& time);
/// The payload has the size of the whole sample.
Change received_change(const GuidPrefix& from, const DataFrag& frag,
                       const std::optional<Time>& time);

}  // namespace ddssec::rtps
