// The common base class of publishers and subscribers: their members and the policies that apply to
// all of them.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rtps/dcps/endpoint.hpp"

namespace ddssec::rtps {

/// PublisherQos and SubscriberQos (DDS 1.4, 2.2.3).
struct GroupQos {
  Presentation presentation = {};
  std::vector<std::string> partition = {};
  Bytes group_data = {};
  bool autoenable_created_entities = true;
  bool operator==(const GroupQos&) const = default;
};

/// Returns an endpoint's policies combined with those of its group and topic, as discovery
/// announces them.
/// Errors: rtps_qos_inconsistent (the policies contradict each other, or the endpoint's own Qos
/// sets policies that belong to the group or the topic).
Result<Qos> announced_qos(Qos endpoint, const GroupQos& group, const Topic& topic);

/// Refuses a change of PRESENTATION. Errors: rtps_immutable_policy.
Status check_mutable(const GroupQos& from, const GroupQos& to);

/// Copies to the endpoint the policies that topics and endpoints both have (copy_from_topic_qos of
/// DDS 1.4).
void copy_from_topic_qos(Qos& endpoint, const Qos& topic);

/// A publisher or a subscriber. Created and deleted by its participant.
class Group : public Entity {
 public:
  ~Group() override;

  DomainParticipant& participant() const { return participant_; }
  /// Returns the policies that are in force.
  GroupQos qos() const;
  /// Changes the policies and announces them for all its writers or readers. Errors:
  /// rtps_immutable_policy (PRESENTATION, once it is enabled), rtps_qos_inconsistent; for a secured
  /// participant those of access control, if it may not use the partitions.
  Status set_qos(const GroupQos& qos);
  Status enable() override;
  /// Deletes its writers or readers with their conditions. Pointers to them are invalid afterwards.
  /// Errors: rtps_precondition_not_met (called from within a callback).
  Status delete_contained_entities();

 protected:
  friend class BuiltinTopics;
  friend class Groups;
  Group(DomainParticipant& participant, ParticipantContext& context, GroupQos qos,
        const Qos& default_endpoint_qos, std::string_view name);

  /// Returns the PRESENTATION of its members. The caller holds the lock.
  const Presentation& presentation_of_members() const { return qos_.presentation; }
  Qos default_endpoint_qos() const;
  Status set_default_endpoint_qos(const Qos& qos);

  /// Creates a member of class E on a topic of that type. Errors: rtps_bad_parameter (the topic has
  /// another type), rtps_precondition_not_met (the topic belongs to another participant),
  /// rtps_qos_inconsistent.
  template <class E, class L>
  Result<E*> create(Topic& topic, std::string_view type, std::optional<Qos> qos, L* listener,
                    StatusMask mask) {
    return create<E>(topic, type, std::move(qos), [&](E& member) -> Status {
      member.set_listener(listener, mask);
      return {};
    });
  }
  /// As the function above, but calls `prepare` with the member before the member can be enabled.
  /// Errors: also those of `prepare`.
  template <class E, class Prepare>
  Result<E*> create(Topic& topic, std::string_view type, std::optional<Qos> qos, Prepare prepare) {
    if (auto fits = check_topic(topic, type); !fits) return std::unexpected(fits.error());
    std::unique_ptr<E> member(
        new E(*this, context_, topic, std::move(qos).value_or(default_endpoint_qos())));
    auto* out = member.get();
    if (auto ready = prepare(*out); !ready) return std::unexpected(ready.error());
    if (auto adopted = adopt(std::move(member)); !adopted) return std::unexpected(adopted.error());
    return out;
  }
  /// Deletes the member. Errors: rtps_precondition_not_met (it belongs to another group or is in
  /// use, or the call is made from within a callback).
  Status delete_member(Endpoint& member);
  /// Returns any member on that topic, or nullptr if there is none.
  Endpoint* lookup(std::string_view topic_name) const;

  /// Sends what the end of these members means to peers, before the members are deleted. Waits for
  /// acknowledgments for at most kMaxLinger.
  static void conclude(std::span<const std::unique_ptr<Endpoint>> members);
  static constexpr std::chrono::milliseconds kMaxLinger{100};

  DomainParticipant& participant_;
  std::vector<std::unique_ptr<Endpoint>> members_;

 private:
  Status check_topic(const Topic& topic, std::string_view type) const;
  Status adopt(std::unique_ptr<Endpoint> member);
  Status remove_member(Endpoint& member, std::unique_ptr<Endpoint>& dying);

  const std::string_view name_;
  GroupQos qos_;
  Qos default_qos_;
};

}  // namespace ddssec::rtps
