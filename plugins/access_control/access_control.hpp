// The access control plugin DDS:Access:Permissions (DDS-Security 1.2, clause 10.4).
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "base/plugin_services.hpp"
#include "plugins/spi/access_control.hpp"

namespace ddssec::access_control {

/// Limits, and what the host can do. A document that needs a feature which the host lacks is
/// refused.
struct AccessControlOptions {
  /// The largest permissions document that is taken from a peer, in octets.
  std::size_t max_permissions_octets = 16 * 1024 * 1024;
  /// The largest number of permissions handles in use at a time.
  std::size_t max_handles = 65536;
  /// The "legacy" mode of DDS-Security 1.2, clause 10.4.1.5.3.4.1.4: an allow rule must list one of
  /// an entity's partitions, not all of them.
  bool one_partition_suffices = false;
  /// True to answer is_relay_only to a reader that only a relay element lets in. Set it only if the
  /// cryptography then keeps the payload key to itself; otherwise such a reader could read.
  bool accept_relays = false;
  /// True to take a governance that enables key revision, because the host revises keys. Otherwise
  /// such a document is refused, because it would exclude no participant.
  bool host_revises_keys = false;
  /// True to take a governance that demands pre-shared keys, because the host protects messages by
  /// them. Otherwise such a document is refused, because nothing would be protected.
  bool host_has_pre_shared_keys = false;
  /// True if the host gives existing endpoints the protection of a pending governance document, and
  /// then applies the document. Otherwise a document that changes the protection of topics in use
  /// is refused.
  bool host_changes_protection = false;
  /// True if the host presents renewed permissions to peers. It is asked for each local
  /// participant. If it does not, the former permissions stay in force, because permissions that
  /// are not presented must not count.
  std::function<bool()> presents_renewed_permissions = [] { return true; };
};

/// The largest number of judged documents, and of their octets, that are kept for later peers.
inline constexpr std::size_t kMaxCachedDocuments = 256;
inline constexpr std::size_t kMaxCachedOctets = 64 * 1024 * 1024;
/// Makes a plugin without any participant; `services` must outlive it. Each local participant's own
/// documents govern what it may do and which peers it trusts.
std::unique_ptr<spi::AccessControl> make_access_control(const PluginServices& services,
                                                        AccessControlOptions options = {});

}  // namespace ddssec::access_control
