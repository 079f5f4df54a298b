// Finds the endpoint of a remote participant that sent a protected submessage, by the key id in it.
//
// A peer may have thousands of endpoints that come and go one by one, so no change may copy all
// routes. Routes are stored in sorted runs; readers see all runs as a whole, without a lock. A new
// route is a run of its own. It is merged with the runs before it that are at most eight times as
// long: n routes cost about n log n copies. The route of a removed endpoint stays in its run and
// leads nowhere, because the registry no longer knows the handle. So removal needs neither memory
// nor a copy. Such a route is removed by a later merge. All runs are merged if half of all routes
// lead nowhere when one is added.
//
// A key revision keeps the key id. While some endpoints of a local participant have the revised key
// and others have not, only the former get routes: they can open messages under either key, and
// know when the former key ends. An endpoint may be left without the revised key for long, if its
// host suspended the match.
#pragma once

#include <compare>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/cryptography/reclaim.hpp"
#include "plugins/cryptography/registry.hpp"

namespace ddssec::cryptography {

struct KeyMaterial;
struct RemoteEndpointCrypto;
class ReceiveKey;

/// The receiver of a protected submessage: how a key id that a message names leads to a match.
struct Route {
  KeyId key_id;           ///< zero for the key of the key exchange
  KeyId receiver_key_id;  ///< zero if there is none
  std::int64_t local_participant;
  EntityKind kind;  ///< remote_writer or remote_reader
  std::int64_t handle;
  std::uint64_t
      number;  ///< valid while the endpoint has the same number (RemoteEndpointCrypto::route)
  auto operator<=>(const Route&) const = default;
};

/// The routes to one remote participant's endpoints.
class Routes {
 public:
  explicit Routes(const Registry& registry) : registry_(registry) {}

  /// Adds a route, after the endpoint got the route's number. One caller at a time.
  void add(const Route& route, RetiredObjects& retired_objects);
  /// Call it after a route has ceased to lead to its endpoint. One caller at a time.
  void note_gone() noexcept { ++gone_; }
  /// True if another endpoint of the same local participant has a route to a later revision of the
  /// endpoint's key. False for a key with a receiver-specific part, because each message names the
  /// receivers that can open it. One caller at a time.
  bool is_outdated(const RemoteEndpointCrypto& endpoint) const;
  /// Ends the routes to earlier revisions of the endpoint's key, for the same local participant and
  /// with the same exception. One caller at a time.
  void end_outdated(const RemoteEndpointCrypto& endpoint);

  /// Returns the endpoint that sent a SEC_ group under the key `key`, as matched with the local
  /// participant `receiver` (0 for any). Several endpoints may have one key, for example a remote
  /// writer that is matched with several local readers. Then the result is the one for which the
  /// group has a MAC, or else the first. nullptr if there is none. Under a ReadGuard.
  RemoteEndpointCrypto* find(KeyId key, std::int64_t receiver, BytesView group) const;
  /// Returns the id of an endpoint other than `owner` that has that key; zero if none is known.
  /// Only the caller of `add` may call it.
  EntityId other_owner(KeyId key, const EntityId& owner) const;
  /// Returns a key of the same sender that an endpoint has, whatever the receiver-specific part;
  /// nullptr if there is none. Only the caller of `add` may call it.
  const ReceiveKey* same_sender_key(const KeyMaterial& material) const;

 private:
  using Run = std::vector<Route>;  // sorted
  class Table final : public RetirableObject {
   public:
    std::span<const std::span<const Route>> runs() const { return views_; }  ///< the longest first
    const std::vector<std::shared_ptr<const Run>>& owners() const { return owners_; }
    void append(std::shared_ptr<const Run> run);

   private:
    std::vector<std::span<const Route>> views_;
    std::vector<std::shared_ptr<const Run>> owners_;
  };
  struct FoundRoute {
    const Route* route = nullptr;
    RemoteEndpointCrypto* endpoint = nullptr;
  };

  RemoteEndpointCrypto* endpoint_of(const Route& route) const;
  template <class Like>
  FoundRoute first_of(std::span<const Route> routes, std::int64_t receiver, Like&& like) const;
  RemoteEndpointCrypto* find_by_mac(const Table& table, KeyId key, std::int64_t receiver,
                                    BytesView group) const;
  template <class F>
  void each_rival(const RemoteEndpointCrypto& endpoint, F&& f) const;
  Run merged(const Run& a, const Run& b) const;

  const Registry& registry_;
  PublishedPointer<Table> table_;
  std::size_t gone_ = 0;  ///< the largest number of routes that may lead nowhere
};

}  // namespace ddssec::cryptography
