// spi::AccessControl as Cyclone's dds_security_access_control.
#pragma once

#include <atomic>

#include "plugins/cyclonedds/closed_readers.hpp"
#include "plugins/cyclonedds/context.hpp"
#include "plugins/cyclonedds/expiry_timer.hpp"
#include "plugins/cyclonedds/governance_facts.hpp"
#include "plugins/cyclonedds/shared_memory.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// The C struct is the base; the host sees only that. One for each domain.
class AccessControlAdapter final : public dds_security_access_control {
 public:
  AccessControlAdapter(
      std::unique_ptr<Host> host, const MakeEngine<spi::AccessControl>& make, ddsi_domaingv* domain,
      SharedMemoryGuard::Probe find_bypass = [] { return cyclonedds::find_bypass(); });
  ~AccessControlAdapter();
  AccessControlAdapter(const AccessControlAdapter&) = delete;
  AccessControlAdapter& operator=(const AccessControlAdapter&) = delete;

  /// What cryptography asks (abi.hpp). Each adapter is asked about its own endpoints; one that is
  /// gone, which Cyclone ends after cryptography, is unknown.
  static MatchVerdict judge(const MatchQuestion* question) noexcept;

  /// What authentication asks about the governance of that local participant, in whatever domain: a
  /// mask of GovernanceFact.
  static std::uint32_t governance_facts_of(spi::IdentityHandle local) noexcept;

  /// What authentication tells about a local participant of whatever domain.
  static void cut_off(spi::IdentityHandle local);

  static AccessControlAdapter& of(dds_security_access_control& instance) {
    return static_cast<AccessControlAdapter&>(instance);
  }
  Host& host() { return *host_; }
  spi::AccessControl& engine() { return *engine_; }
  SharedMemoryGuard& shared_memory() { return shared_memory_; }
  GovernanceFacts& facts() { return facts_; }
  /// A property wants the host to ask peers for types.
  void trust_type_information() { trusts_type_information_ = true; }
  /// Open also where a stock cryptography shows the host the types of peers, for then it asks for
  /// them.
  TypeLookup type_lookup() const;
  /// Unique within the process.
  std::uint64_t id() const { return id_; }

  /// Null stops the timer; returns when no revocation is running any more.
  void listen(const dds_security_access_control_listener* listener);

 private:
  /// Among those of the process that may be asked.
  void enlist();
  void delist();

  const std::uint64_t id_;
  std::unique_ptr<Host> host_;
  std::unique_ptr<spi::AccessControl> engine_;
  SharedMemoryGuard shared_memory_;
  GovernanceFacts facts_;
  std::atomic<bool> trusts_type_information_ = false;
  ExpiryTimer timer_;  ///< last: it ends before what it uses
};

}  // namespace ddssec::cyclonedds
