// Adapts spi::AccessControl to Cyclone's dds_security_access_control.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "plugins/cyclonedds/adapter_calls.hpp"
#include "plugins/cyclonedds/closed_readers.hpp"
#include "plugins/cyclonedds/expiry_timer.hpp"
#include "plugins/cyclonedds/governance_facts.hpp"
#include "plugins/cyclonedds/own_endpoints.hpp"
#include "plugins/cyclonedds/peer_permissions.hpp"
#include "plugins/cyclonedds/shared_memory_guard.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::cyclonedds {

/// The adapter of one domain. The C struct is the base class; the host sees only that.
class AccessControlAdapter final : public dds_security_access_control {
 public:
  AccessControlAdapter(
      std::unique_ptr<Host> host, const MakePlugin<spi::AccessControl>& make, ddsi_domaingv* domain,
      SharedMemoryGuard::Probe find_bypass = [] { return cyclonedds::find_bypass(); });
  ~AccessControlAdapter();
  AccessControlAdapter(const AccessControlAdapter&) = delete;
  AccessControlAdapter& operator=(const AccessControlAdapter&) = delete;

  /// Answers cryptography's question (abi.hpp). Each adapter answers for its own endpoints. An
  /// adapter that is already destroyed is unknown; Cyclone destroys it after cryptography.
  static MatchVerdict judge(const MatchQuestion* question) noexcept;

  /// Answers authentication's question about the governance of a local participant in any domain: a
  /// mask of GovernanceFact.
  static std::uint32_t governance_facts_of(spi::IdentityHandle local) noexcept;

  struct RenewedDocument {
    std::uint64_t times;
    std::string text;  ///< the signed document
  };
  /// Answers authentication's question: returns the permissions of a local participant of any
  /// domain, if they were renewed more than `known` times.
  static std::optional<RenewedDocument> renewed_permissions(spi::IdentityHandle local,
                                                            std::uint64_t known) noexcept;

  /// Answers authentication's question: the number of times that renewed permissions of a local
  /// participant of any domain changed the rights of one of its endpoints (OwnEndpoints::poll).
  static std::uint64_t rights_changed(spi::IdentityHandle local) noexcept;

  /// Drops the permissions of a remote participant that the host has forgotten, in any domain.
  /// Authentication calls this.
  static void return_permissions_of(spi::IdentityHandle peer) noexcept;

  /// Cuts off a local participant of any domain. Authentication calls this.
  static void cut_off(spi::IdentityHandle local);

  static AccessControlAdapter& of(dds_security_access_control& instance) {
    return static_cast<AccessControlAdapter&>(instance);
  }
  Host& host() { return *host_; }
  spi::AccessControl& plugin() { return *plugin_; }
  SharedMemoryGuard& shared_memory() { return shared_memory_; }
  GovernanceFacts& facts() { return facts_; }
  OwnEndpoints& endpoints() { return endpoints_; }
  PeerPermissions& peer_permissions() { return peer_permissions_; }
  /// The id of the host's domain, as in the last call that names it.
  void set_domain_id(std::uint32_t id) { domain_id_ = id; }
  std::uint32_t domain_id() const { return domain_id_; }
  /// The host's authentication plugin, as in the last call that names it; nullptr before.
  void set_authentication(const dds_security_authentication* plugin) { authentication_ = plugin; }
  const dds_security_authentication* authentication() const { return authentication_; }
  /// Notes that a property demands that the host asks peers for types.
  void trust_type_information() { trusts_type_information_ = true; }
  /// Returns whether the readers of type lookup stay open. They also stay open with a stock
  /// cryptography plugin, which shows peers' types to the host, so that the host asks for them.
  TypeLookup type_lookup() const;
  /// Returns the id of this adapter, unique within the process.
  std::uint64_t id() const { return id_; }

  /// Sets the listener. nullptr stops the timer; the call returns when no revocation is running any
  /// more.
  void listen(const dds_security_access_control_listener* listener);

 private:
  using Revoke = std::function<void(spi::PermissionsHandle)>;
  void revoke_ended(const std::stop_token& stop, const Revoke& revoke);
  /// Reports endpoints whose rights renewed permissions have changed.
  void poll_endpoints();
  /// Adds this adapter to, or removes it from, the list of adapters in the process.
  void register_in_process();
  void unregister_from_process();

  const std::uint64_t id_;
  std::unique_ptr<Host> host_;
  std::unique_ptr<spi::AccessControl> plugin_;
  SharedMemoryGuard shared_memory_;
  GovernanceFacts facts_;
  OwnEndpoints endpoints_;
  PeerPermissions peer_permissions_ = {};
  std::atomic<std::uint32_t> domain_id_ = 0;
  std::atomic<const dds_security_authentication*> authentication_ = nullptr;
  std::atomic<bool> trusts_type_information_ = false;
  ExpiryTimer timer_;  ///< last member: destroyed before the objects that it uses
};

}  // namespace ddssec::cyclonedds
