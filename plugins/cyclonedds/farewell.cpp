#include "plugins/cyclonedds/farewell.hpp"

#include <array>

#include "base/writer.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr EntityId kParticipant{{0, 0, 1, 0xc1}};
constexpr EntityId kSpdpWriter{{0, 1, 0, 0xc2}}, kSpdpReader{{0, 1, 0, 0xc7}};

void write_guid(Writer& out, const GuidPrefix& prefix) {
  out.write_bytes(prefix.view());
  out.write_bytes(kParticipant.view());
}

}  // namespace

Bytes write_farewell(const GuidPrefix& own, const GuidPrefix& peer) {
  constexpr std::uint8_t kInfoDestination = 0x0e, kData = 0x15;
  constexpr std::uint8_t kInlineQosAndKey = 0x02 | 0x08;
  constexpr std::uint16_t kKeyHash = 0x70, kStatusInfo = 0x71, kParticipantGuid = 0x50,
                          kSentinel = 1;
  Writer out(Endian::big, 120);
  out.write_bytes(as_bytes("RTPS"));
  out.write_bytes(std::array<std::uint8_t, 4>{2, 5, 1, 0x10});  // as the host's own messages
  out.write_bytes(own.view());
  out.write(kInfoDestination);
  out.write(std::uint8_t{0});
  out.write(std::uint16_t{12});
  out.write_bytes(peer.view());
  out.write(kData);
  out.write(kInlineQosAndKey);
  out.write(std::uint16_t{80});
  out.write(std::uint16_t{0});
  out.write(std::uint16_t{16});  // octets to the inline QoS
  out.write_bytes(kSpdpReader.view());
  out.write_bytes(kSpdpWriter.view());
  out.write(std::uint64_t{2});
  out.write(kKeyHash);
  out.write(std::uint16_t{16});
  write_guid(out, own);
  out.write(kStatusInfo);
  out.write(std::uint16_t{4});
  out.write(std::uint32_t{3});  // disposed and unregistered
  out.write(kSentinel);
  out.write(std::uint16_t{0});
  out.write(std::uint32_t{0x00020000});  // PL_CDR_BE
  out.write(kParticipantGuid);
  out.write(std::uint16_t{16});
  write_guid(out, own);
  out.write(kSentinel);
  out.write(std::uint16_t{0});
  return out.take();
}

void Farewells::add_local(spi::IdentityHandle local, const GuidPrefix& prefix, DomainId domain) {
  const std::lock_guard lock(mutex_);
  locals_[local] = {local, prefix, domain};
}

void Farewells::remove_local(spi::IdentityHandle local) {
  const std::lock_guard lock(mutex_);
  locals_.erase(local);
}

std::vector<Farewells::Local> Farewells::locals() const {
  const std::lock_guard lock(mutex_);
  std::vector<Local> out;
  for (const auto& [handle, local] : locals_) out.push_back(local);
  return out;
}

}  // namespace ddssec::cyclonedds
