#include "plugins/cyclonedds/core_timer.hpp"

#include <arpa/inet.h>
#include <bit>
#include <limits>

#include "plugins/cyclonedds/core_handshake.hpp"
#include "plugins/cyclonedds/host_entities.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();  // DDS_NEVER

CoreGuid core_guid(const DDS_Security_GUID_t& guid) {
  auto out = std::bit_cast<CoreGuid>(guid);
  for (auto& number : out) number = ntohl(number);
  return out;
}

}  // namespace

CoreTimer CoreTimer::of_host(const void* code) noexcept {
  return CoreTimer(
      reinterpret_cast<SetTimeout*>(find_host_symbol(code, "dds_security_fsm_set_timeout")));
}

bool CoreTimer::stop(const Call& call) const noexcept {
  if (set_timeout_ == nullptr) return false;
  const auto* const member = reinterpret_cast<const std::byte*>(call.local_auth_request);
  const auto& handshake =
      *reinterpret_cast<const CoreHandshake*>(member - offsetof(CoreHandshake, local_auth_request));
  // Other software would have other values at these places.
  if (handshake.plugin != call.plugin || handshake.domain != call.plugin->gv ||
      handshake.remote != core_guid(*call.remote) || handshake.machine == nullptr ||
      handshake.machine->argument != &handshake)
    return false;
  // The core calls the plugin without the lock that this function takes.
  set_timeout_(handshake.machine, nullptr, kNever);
  return true;
}

}  // namespace ddssec::cyclonedds
