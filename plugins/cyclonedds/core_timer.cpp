#include "plugins/cyclonedds/core_timer.hpp"

#include <arpa/inet.h>
#include <bit>
#include <fcntl.h>
#include <limits>
#include <optional>
#include <unistd.h>

#include "base/file_descriptor.hpp"
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

// Returns the value at an address; empty if it cannot be read. The kernel reads it, and returns an
// error where a read by the process would end the process.
template <class T>
std::optional<T> read_memory(const void* from) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return std::nullopt;
  const FileDescriptor reading(ends[0]), writing(ends[1]);
  constexpr auto kOctets = static_cast<ssize_t>(sizeof(T));
  T out;
  if (::write(writing.number(), from, sizeof(T)) != kOctets) return std::nullopt;
  if (::read(reading.number(), &out, sizeof(T)) != kOctets) return std::nullopt;
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
  const auto* const at = member - offsetof(CoreHandshake, local_auth_request);
  // Other software would have other values at these places, or no readable memory.
  const auto handshake = read_memory<CoreHandshake>(at);
  if (!handshake || handshake->plugin != call.plugin || handshake->domain != call.plugin->gv ||
      handshake->remote != core_guid(*call.remote))
    return false;
  const auto machine = read_memory<CoreStateMachine>(handshake->machine);
  if (!machine || machine->argument != at) return false;
  // The core does not hold the lock that this function takes when it calls the plugin.
  set_timeout_(handshake->machine, nullptr, kNever);
  return true;
}

}  // namespace ddssec::cyclonedds
