// The common base class of writers and readers.
#pragma once

#include <set>

#include "rtps/dcps/key_protection.hpp"
#include "rtps/dcps/topic.hpp"
#include "rtps/participant/endpoint_listener.hpp"

namespace ddssec::rtps {

class Group;
struct GroupQos;

/// A writer or a reader. Created and deleted by its publisher or subscriber. Thread-safe.
class Endpoint : public Entity, protected EndpointListener {
 public:
  ~Endpoint() override = default;

  Topic& topic() const { return topic_; }
  /// Returns the endpoint's GUID; zero until it is enabled.
  Guid guid() const;
  Qos qos() const;
  /// Changes the policies. Errors: rtps_qos_inconsistent, rtps_immutable_policy.
  Status set_qos(const Qos& qos);
  Status enable() override;

 protected:
  friend class Group;
  friend class Groups;
  /// The values that differ between writers and readers.
  struct Side {
    std::string_view name, group;
    StatusKind matched, incompatible_qos, deadline_missed;
  };
  Endpoint(Group& group, ParticipantContext& context, Topic& topic, Qos qos, const Side& side);
  /// Removes the endpoint from the protocol, which makes no further calls to it. Called before the
  /// endpoint is deleted, and by the destructors of derived classes for endpoints whose creation
  /// failed.
  void retire();

  // The caller holds the lock:
  /// Called once, after the endpoint left the protocol.
  virtual void on_retired() = 0;
  virtual Result<Guid> create(EndpointDescription request) = 0;
  /// Called after the endpoint's own policies changed.
  virtual void on_own_qos(const Qos& before) = 0;
  /// Called before the endpoint is deleted: sends what its end means to peers.
  virtual void conclude() {}
  /// Called after conclude(): waits until peers have acknowledged it, or until `deadline`.
  virtual void await_acknowledgment(std::chrono::steady_clock::time_point deadline) {
    (void)deadline;
  }
  /// Checks that the endpoint may be deleted now. Errors: rtps_precondition_not_met.
  virtual Status check_unused() const { return {}; }

  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  void on_incompatible_qos(const Guid& remote, const QosMismatch& mismatch) override;
  void on_inconsistent_topic(const EndpointData& remote) override;
  void on_key_protected() override { keys_.hidden = true; }
  void on_payload_protected() override { keys_.proven = true; }
  void miss_deadline(InstanceHandle instance);
  bool matched_none() const { return remotes_.empty(); }

  // The caller does not hold the lock:
  template <class Status>
  Status read_status(StatusKind kind, Status& status);
  MatchedStatus read_matched_status();
  IncompatibleQosStatus read_incompatible_status() {
    return read_status(side_.incompatible_qos, incompatible_);
  }
  DeadlineMissedStatus read_deadline_status() {
    return read_status(side_.deadline_missed, deadline_missed_);
  }
  std::vector<Guid> matched_remotes() const;
  /// Returns what a matched remote endpoint announced. Errors: rtps_bad_parameter (it is not
  /// matched).
  Result<EndpointData> matched_data(const Guid& remote) const;

  /// Checks that regroup would succeed.
  Status check_regroup(const GroupQos& group);
  /// Announces the endpoint with the changed policies of its group.
  Status regroup(const GroupQos& group);

  Group& group_;
  Topic& topic_;
  const Side side_;
  Guid guid_;
  Qos qos_;
  KeyProtection keys_;

 private:
  bool is_retired_ = false;
  std::set<Guid> remotes_;
  DeadlineMissedStatus deadline_missed_;
  IncompatibleQosStatus incompatible_;
  MatchedStatus matched_;
};

template <class Status>
Status Endpoint::read_status(StatusKind kind, Status& status) {
  const auto held = lock();
  changes_.clear(kind);
  const auto out = status;
  status.total_count_change = 0;
  return out;
}

}  // namespace ddssec::rtps
