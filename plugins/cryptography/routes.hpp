// Which endpoint of a remote participant sent a protected submessage: the key id in it says so.
//
// A peer may have thousands of endpoints, and they come and go one by one, so no change may copy
// all routes. Routes stand in sorted runs; readers see them as a whole, without a lock. A new route
// is a run of its own, merged with the runs before it that are not eight times as long: n routes
// cost some n log n copies. The route of an endpoint that is gone stays in its run and leads
// nowhere, since the registry no longer knows the handle: leaving needs neither memory nor a copy.
// It goes with a later merge; of all runs, if half of all routes lead nowhere when one is added.
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
struct RemoteEndpoint;
class ReceiveKey;

struct Route {
  KeyId key_id;           ///< zero: of the key exchange
  KeyId receiver_key_id;  ///< zero: none
  std::int64_t local_participant;
  EntityKind kind;  ///< remote_writer or remote_reader
  std::int64_t handle;
  std::uint64_t number;  ///< leads to the endpoint while that has the same (RemoteEndpoint::route)
  auto operator<=>(const Route&) const = default;
};

/// The routes to one remote participant's endpoints.
class Routes {
 public:
  explicit Routes(const Registry& registry) : registry_(registry) {}

  /// One caller at a time, after the endpoint got the route's number.
  void add(const Route& route, Graveyard& graveyard);
  /// One caller at a time, after a route has ceased to lead to its endpoint.
  void note_gone() noexcept { ++gone_; }

  /// Under a ReadGuard: the endpoint that a SEC_ group under the key `key` is for, matched with the
  /// local participant `receiver` (0: with any). Several may have one key, a remote writer that is
  /// matched with several of our readers for example: then the one that the group has a MAC for, or
  /// else the first. nullptr if there is none.
  RemoteEndpoint* find(KeyId key, std::int64_t receiver, BytesView group) const;
  /// By the caller of `add`: an endpoint that is not `owner` and has that key; zero if none is
  /// known.
  EntityId other_owner(KeyId key, const EntityId& owner) const;
  /// By the caller of `add`: a key of the same sender that an endpoint has, whatever the receiver's
  /// own part; nullptr if there is none.
  const ReceiveKey* same_sender_key(const KeyMaterial& material) const;

 private:
  using Run = std::vector<Route>;  // sorted
  class Table final : public Retirable {
   public:
    std::span<const std::span<const Route>> runs() const { return views_; }  ///< the longest first
    const std::vector<std::shared_ptr<const Run>>& owners() const { return owners_; }
    void append(std::shared_ptr<const Run> run);

   private:
    std::vector<std::span<const Route>> views_;
    std::vector<std::shared_ptr<const Run>> owners_;
  };
  struct Found {
    const Route* route = nullptr;
    RemoteEndpoint* endpoint = nullptr;
  };

  RemoteEndpoint* endpoint_of(const Route& route) const;
  template <class Like>
  Found first_of(std::span<const Route> routes, std::int64_t receiver, Like&& like) const;
  RemoteEndpoint* find_by_mac(const Table& table, KeyId key, std::int64_t receiver,
                              BytesView group) const;
  Run merged(const Run& a, const Run& b) const;

  const Registry& registry_;
  Published<Table> table_;
  std::size_t gone_ = 0;  ///< at most so many lead nowhere
};

}  // namespace ddssec::cryptography
