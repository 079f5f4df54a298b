#include "rtps/dcps/matched.hpp"

#include <algorithm>

namespace ddssec::rtps {

bool count_matched(MatchedStatus& status, std::vector<Guid>& remotes, const Guid& remote) {
  if (std::ranges::find(remotes, remote) != remotes.end()) return false;
  remotes.push_back(remote);
  status.count();
  ++status.current_count;
  ++status.current_count_change;
  status.last_remote = remote;
  return true;
}

bool count_unmatched(MatchedStatus& status, std::vector<Guid>& remotes, const Guid& remote) {
  if (std::erase(remotes, remote) == 0) return false;
  --status.current_count;
  --status.current_count_change;
  status.last_remote = remote;
  return true;
}

void count_mismatch(IncompatibleQosStatus& status, const Guid& remote,
                    const QosMismatch& mismatch) {
  status.count();
  status.last_policy_id = mismatch.id;
  ++status.policies[mismatch.id];
  status.last = mismatch;
  status.last_remote = remote;
}

MatchedStatus take_changes(MatchedStatus& status) {
  const auto out = status;
  status.total_count_change = status.current_count_change = 0;
  return out;
}

Result<EndpointData> matched_data(const Participant& protocol, const std::vector<Guid>& remotes,
                                  const Guid& remote) {
  const auto* data = std::ranges::find(remotes, remote) == remotes.end()
                         ? nullptr
                         : protocol.remote_endpoint(remote);
  if (data != nullptr) return *data;
  return fail(Code::rtps_bad_parameter,
              {.expected = "a matched endpoint", .found = remote.to_string()});
}

}  // namespace ddssec::rtps
