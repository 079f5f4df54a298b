// What writers and readers count alike about their remote ends.
#pragma once

#include "rtps/dcps/status.hpp"
#include "rtps/discovery/participant.hpp"

namespace ddssec::rtps {

/// False: it was matched already.
bool count_matched(MatchedStatus& status, std::vector<Guid>& remotes, const Guid& remote);
/// False: it was not matched.
bool count_unmatched(MatchedStatus& status, std::vector<Guid>& remotes, const Guid& remote);
void count_mismatch(IncompatibleQosStatus& status, const Guid& remote, const QosMismatch& mismatch);
/// A copy; the changes begin again at 0.
MatchedStatus take_changes(MatchedStatus& status);
/// What a matched remote announced. Errors: rtps_bad_parameter.
Result<EndpointData> matched_data(const Participant& protocol, const std::vector<Guid>& remotes,
                                  const Guid& remote);

}  // namespace ddssec::rtps
