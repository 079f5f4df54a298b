#include "plugins/cyclonedds/dispose_announcements.hpp"

#include "plugins/cyclonedds/disposal.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/info_destination.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::cyclonedds {

Bytes write_dispose_announcement(const GuidPrefix& own, const GuidPrefix& peer) {
  Bytes octets(128);
  rtps::SpanWriter out(octets);
  // The header names the same vendor as the host does.
  write(out, rtps::Header{.vendor = rtps::kVendorCyclone, .prefix = own});
  write(out, rtps::InfoDestination{peer});
  write(out, Disposal{.reader = rtps::kSpdpReader,
                      .writer = rtps::kSpdpWriter,
                      .number = rtps::SequenceNumber{2},
                      .key = pid::kParticipantGuid,
                      .gone = {own, kEntityIdParticipant}});
  octets.resize(out.size());
  return octets;
}

void DisposeAnnouncements::add_local(spi::IdentityHandle local, const GuidPrefix& prefix) {
  const std::lock_guard lock(mutex_);
  locals_[local] = {local, prefix};
}

void DisposeAnnouncements::remove_local(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  locals_.erase(local);
}

std::vector<DisposeAnnouncements::Local> DisposeAnnouncements::locals() const {
  const std::lock_guard lock(mutex_);
  std::vector<Local> out;
  for (const auto& [handle, local] : locals_) out.push_back(local);
  return out;
}

}  // namespace ddssec::cyclonedds
