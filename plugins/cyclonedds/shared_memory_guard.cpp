#include "plugins/cyclonedds/shared_memory_guard.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <unistd.h>

#include "base/rollback.hpp"
#include "plugins/cyclonedds/loaded_symbols.hpp"
#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr std::string_view kIceoryxSetting = "<SharedMemory><Enable>";
constexpr std::string_view kPsmxSetting = "<PubSubMessageExchange>";

// Returns the path in the last column; only that column contains slashes.
std::string_view path_of(std::string_view mapping) {
  const auto slash = mapping.find('/');
  return slash == std::string_view::npos ? std::string_view() : mapping.substr(slash);
}

// Up to iceoryx 2 the management segment is "iceoryx_mgmt"; later versions put the kind of
// resource before it. The name of an unlinked segment ends with " (deleted)".
bool is_iceoryx_segment(std::string_view path) {
  const auto name = path.substr(path.rfind('/') + 1);
  return name.starts_with("iceoryx_mgmt") || name.starts_with("iox1_") || name.starts_with("iox2_");
}

// Reads a file of the kernel, which has no length, up to its end; empty if it cannot be read.
std::optional<std::string> whole_file(const char* path) {
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return std::nullopt;
  const Rollback close_it([&] { close(file); });
  constexpr std::size_t kStep = 64 * 1024;
  std::string text;
  for (;;) {
    const auto before = text.size();
    text.resize(before + kStep);
    const auto octets = read(file, text.data() + before, kStep);
    if (octets < 0 && errno != EINTR) return std::nullopt;
    text.resize(before + static_cast<std::size_t>(std::max<ssize_t>(octets, 0)));
    if (octets == 0) break;
  }
  if (text.empty()) return std::nullopt;
  return text;
}

}  // namespace

std::optional<std::string> iceoryx_segment(std::string_view mappings) {
  while (!mappings.empty()) {
    const auto line = mappings.substr(0, mappings.find('\n'));
    if (const auto path = path_of(line); is_iceoryx_segment(path)) return std::string(path);
    mappings.remove_prefix(std::min(line.size() + 1, mappings.size()));
  }
  return std::nullopt;
}

Result<std::optional<Bypass>> find_bypass(const char* mappings_file) {
  if (auto symbol = find_loaded_symbol("_create_psmx"))
    return Bypass{kPsmxSetting, symbol->name + " in " +
                                    (symbol->library.empty() ? "the program" : symbol->library)};
  const auto mappings = whole_file(mappings_file);
  if (!mappings) return fail(Code::shared_memory_undecidable, {.document = mappings_file});
  if (auto segment = iceoryx_segment(*mappings))
    return Bypass{kIceoryxSetting, *std::move(segment) + " is mapped"};
  return std::nullopt;
}

std::string promise_for_samples(const spi::ParticipantSecurityAttributes& participant,
                                const spi::EndpointSecurityAttributes& endpoint,
                                EndpointDirection direction) {
  const auto kind = [](std::string_view element, spi::ProtectionKind value) {
    return std::string(element) + ' ' + std::string(spi::to_string(value));
  };
  if (endpoint.is_payload_protected()) return kind("data_protection_kind", endpoint.payload);
  if (endpoint.is_submessage_protected())
    return kind("metadata_protection_kind", endpoint.submessage);
  if (participant.is_rtps_protected()) return kind("rtps_protection_kind", participant.rtps);
  if (direction == EndpointDirection::writes && endpoint.topic.is_read_protected)
    return "enable_read_access_control true";
  if (direction == EndpointDirection::reads && endpoint.topic.is_write_protected)
    return "enable_write_access_control true";
  return {};
}

Result<bool> SharedMemoryGuard::is_allowed_by(const spi::PropertyList& properties) {
  return spi::flag_property(properties, spi::property::kAllowSharedMemory);
}

void SharedMemoryGuard::allow(spi::PermissionsHandle participant) {
  const std::scoped_lock lock(mutex_);
  allowed_.insert(participant.value);
}

bool SharedMemoryGuard::is_allowed(spi::PermissionsHandle participant) const {
  const std::scoped_lock lock(mutex_);
  return allowed_.contains(participant.value);
}

void SharedMemoryGuard::forget(spi::PermissionsHandle participant) {
  const std::scoped_lock lock(mutex_);
  allowed_.erase(participant.value);
}

Result<std::optional<Bypass>> SharedMemoryGuard::bypass() {
  const std::scoped_lock lock(mutex_);
  if (!known_) {
    DDSSEC_ASSIGN_OR_RETURN(known_, probe_());
  }
  return *known_;
}

Status SharedMemoryGuard::check(std::string_view topic, std::string_view promise) {
  DDSSEC_ASSIGN_OR_RETURN(const auto found, bypass());
  if (!found) return {};
  return fail(Code::shared_memory_bypasses_protection,
              {.document = "Cyclone DDS's configuration",
               .field = std::string(found->setting),
               .expected = "shared memory off, as governance promises " + std::string(promise) +
                           " for topic " + std::string(topic),
               .found = found->seen});
}

}  // namespace ddssec::cyclonedds
