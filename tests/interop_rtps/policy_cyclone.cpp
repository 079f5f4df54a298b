// The policy peer on Cyclone DDS.
#include <dds/dds.h>

#include "appendable_shape.h"
#include "interop_rtps/policy_peer.hpp"
#include "shape.h"

namespace {

using policy_peer::End;
using policy_peer::Policies;

constexpr char kLoopback[] =
    "<CycloneDDS><Domain Id=\"any\">"
    "<General><Interfaces><NetworkInterface address=\"127.0.0.1\" multicast=\"false\"/>"
    "</Interfaces><AllowMulticast>false</AllowMulticast></General>"
    "<Discovery><Peers><Peer address=\"127.0.0.1\"/></Peers>"
    "<ParticipantIndex>auto</ParticipantIndex><SPDPInterval>500ms</SPDPInterval></Discovery>"
    "</Domain></CycloneDDS>";

struct Qos {
  dds_qos_t* value = dds_create_qos();
  ~Qos() { dds_delete_qos(value); }
};

void set_qos(dds_qos_t* qos, const Policies& p) {
  const bool best_effort = p.is("reliability", "best_effort");
  dds_qset_reliability(qos, best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                       DDS_SECS(1));
  const bool all = p.is("history", "all");
  const auto kind = all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST;
  const auto depth = p.has("history") && !all ? static_cast<int32_t>(p.number("history")) : 1;
  dds_qset_history(qos, kind, depth);
  if (p.is("durability", "transient_local")) {
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    // This is also for late joiners, because Cyclone DDS applies it to this kind of durability.
    if (p.has("service"))
      dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST,
                                  static_cast<int32_t>(p.number("service")), -1, -1, -1);
    else
      dds_qset_durability_service(qos, 0, kind, depth, -1, -1, -1);
  }
  if (p.has("budget")) dds_qset_latency_budget(qos, DDS_MSECS(p.number("budget")));
  if (const auto user = p.text("user"); !user.empty())
    dds_qset_userdata(qos, user.data(), user.size());
  if (p.has("deadline")) dds_qset_deadline(qos, DDS_MSECS(p.number("deadline")));
  if (p.has("lifespan")) dds_qset_lifespan(qos, DDS_MSECS(p.number("lifespan")));
  const auto liveliness = p.is("liveliness", "topic")         ? DDS_LIVELINESS_MANUAL_BY_TOPIC
                          : p.is("liveliness", "participant") ? DDS_LIVELINESS_MANUAL_BY_PARTICIPANT
                                                              : DDS_LIVELINESS_AUTOMATIC;
  dds_qset_liveliness(qos, liveliness,
                      p.has("lease") ? DDS_MSECS(p.number("lease")) : DDS_INFINITY);
  if (p.is("ownership", "exclusive")) dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE);
  if (p.has("strength"))
    dds_qset_ownership_strength(qos, static_cast<int32_t>(p.number("strength")));
  if (p.is("order", "source"))
    dds_qset_destination_order(qos, DDS_DESTINATIONORDER_BY_SOURCE_TIMESTAMP);
  if (p.has("representation")) {
    const dds_data_representation_id_t id =
        p.is("representation", "2") ? DDS_DATA_REPRESENTATION_XCDR2 : DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos, 1, &id);
  }
  if (p.has("types"))
    dds_qset_type_consistency(qos,
                              p.is("types", "same") ? DDS_TYPE_CONSISTENCY_DISALLOW_TYPE_COERCION
                                                    : DDS_TYPE_CONSISTENCY_ALLOW_TYPE_COERCION,
                              true, true, false, false, true);
  dds_qset_writer_data_lifecycle(qos, p.is("autodispose", "on"));
}

class Cyclone final : public policy_peer::Stack {
 public:
  Cyclone(dds_entity_t participant, const dds_topic_descriptor_t& type)
      : participant_(participant), type_(type) {}

  bool writer(const std::string& id, const std::string& topic, const Policies& p) override {
    return create(id, topic, p, dds_create_publisher, dds_create_writer);
  }
  bool reader(const std::string& id, const std::string& topic, const Policies& p) override {
    return create(id, topic, p, dds_create_subscriber, dds_create_reader);
  }
  bool remove(const std::string& id) override { return dds_delete(entities_.at(id)) == 0; }
  bool write(const std::string& id, const std::string& color, int x,
             std::int64_t source_ms) override {
    auto shape = shape_of(color, x);
    const auto entity = entities_.at(id);
    return (source_ms < 0 ? dds_write(entity, &shape)
                          : dds_write_ts(entity, &shape, DDS_MSECS(source_ms))) == 0;
  }
  bool end(const std::string& id, const std::string& color, End how) override {
    auto shape = shape_of(color, 0);
    const auto entity = entities_.at(id);
    return (how == End::dispose ? dds_dispose(entity, &shape)
                                : dds_unregister_instance(entity, &shape)) == 0;
  }
  bool assert_liveliness(const std::string& id) override {
    return dds_assert_liveliness(entities_.at(id)) == 0;
  }
  bool enable(const std::string&) override { return false; }  // has no ENTITY_FACTORY
  std::string told(const std::string& id) override {
    const auto entity = entities_.at(id);
    dds_instance_handle_t remote = 0;
    const bool writes = is_writer_.at(id);
    if ((writes ? dds_get_matched_subscriptions(entity, &remote, 1)
                : dds_get_matched_publications(entity, &remote, 1)) < 1)
      return "";
    auto* data = writes ? dds_get_matched_subscription_data(entity, remote)
                        : dds_get_matched_publication_data(entity, remote);
    std::string out;
    for (const auto& [name, ask] :
         {std::pair(" user=", &dds_qget_userdata), std::pair(" topic=", &dds_qget_topicdata),
          std::pair(" group=", &dds_qget_groupdata)}) {
      void* octets = nullptr;
      size_t size = 0;
      out += name;
      if (ask(data->qos, &octets, &size) && size > 0) out.append(static_cast<char*>(octets), size);
      dds_free(octets);
    }
    dds_builtintopic_free_endpoint(data);
    return out.substr(1);
  }
  std::string take(const std::string& id) override {
    std::string out;
    void* raw = nullptr;
    dds_sample_info_t info;
    while (dds_take(entities_.at(id), &raw, &info, 1, 1) == 1) {
      const auto& shape = *static_cast<const interop_Shape*>(raw);
      out += std::string(" ") + shape.color + ":" +
             (info.valid_data ? std::to_string(shape.x) : "-") + ":" +
             (info.instance_state == DDS_IST_ALIVE                ? "A"
              : info.instance_state == DDS_IST_NOT_ALIVE_DISPOSED ? "D"
                                                                  : "N");
      dds_return_loan(entities_.at(id), &raw, 1);
      raw = nullptr;
    }
    return out;
  }
  std::string status(const std::string& id) override {
    const auto entity = entities_.at(id);
    std::ostringstream out;
    if (is_writer_.at(id)) {
      dds_publication_matched_status_t matched{};
      dds_offered_incompatible_qos_status_t qos{};
      dds_offered_deadline_missed_status_t deadline{};
      dds_liveliness_lost_status_t lost{};
      dds_get_publication_matched_status(entity, &matched);
      dds_get_offered_incompatible_qos_status(entity, &qos);
      dds_get_offered_deadline_missed_status(entity, &deadline);
      dds_get_liveliness_lost_status(entity, &lost);
      out << "matched=" << matched.current_count << " incompatible=" << qos.last_policy_id
          << " deadline=" << deadline.total_count << " lost=" << lost.total_count;
    } else {
      dds_subscription_matched_status_t matched{};
      dds_requested_incompatible_qos_status_t qos{};
      dds_requested_deadline_missed_status_t deadline{};
      dds_liveliness_changed_status_t lives{};
      dds_get_subscription_matched_status(entity, &matched);
      dds_get_requested_incompatible_qos_status(entity, &qos);
      dds_get_requested_deadline_missed_status(entity, &deadline);
      dds_get_liveliness_changed_status(entity, &lives);
      out << "matched=" << matched.current_count << " incompatible=" << qos.last_policy_id
          << " deadline=" << deadline.total_count << " alive=" << lives.alive_count
          << " not_alive=" << lives.not_alive_count;
    }
    return out.str();
  }

 private:
  static interop_Shape shape_of(const std::string& color, int x) {
    interop_Shape shape{};
    shape.color = const_cast<char*>(color.c_str());
    shape.x = x, shape.y = 2 * x, shape.shapesize = 30;
    return shape;
  }
  template <class Group, class Create>
  bool create(const std::string& id, const std::string& topic, const Policies& p, Group make_group,
              Create make) {
    const Qos qos, group;
    set_qos(qos.value, p);
    if (p.has("partition")) dds_qset_partition1(group.value, p.text("partition").c_str());
    const auto scope = p.is("scope", "topic")   ? DDS_PRESENTATION_TOPIC
                       : p.is("scope", "group") ? DDS_PRESENTATION_GROUP
                                                : DDS_PRESENTATION_INSTANCE;
    dds_qset_presentation(group.value, scope, p.is("coherent", "on"), false);
    if (const auto data = p.text("group"); !data.empty())
      dds_qset_groupdata(group.value, data.data(), data.size());
    const Qos of_topic;
    if (const auto data = p.text("topic"); !data.empty())
      dds_qset_topicdata(of_topic.value, data.data(), data.size());
    const auto on = dds_create_topic(participant_, &type_, topic.c_str(), of_topic.value, nullptr);
    const auto parent = make_group(participant_, group.value, nullptr);
    const auto entity = make(parent, on, qos.value, nullptr);
    entities_[id] = entity;
    is_writer_[id] = std::is_same_v<Create, decltype(&dds_create_writer)> &&
                     reinterpret_cast<void*>(make) == reinterpret_cast<void*>(&dds_create_writer);
    return entity > 0;
  }

  const dds_entity_t participant_;
  const dds_topic_descriptor_t& type_;
  std::map<std::string, dds_entity_t> entities_;
  std::map<std::string, bool> is_writer_;
};

}  // namespace

// Both types have the same members, so they have the same struct in C.
static_assert(sizeof(interop_Shape) == sizeof(growing_Shape));

int main(int argc, char**) {
  if (dds_create_domain(0, kLoopback) < 0) return 3;
  const auto participant = dds_create_participant(0, nullptr, nullptr);
  if (participant < 0) return 3;
  Cyclone stack(participant, argc > 1 ? growing_Shape_desc : interop_Shape_desc);
  const int code = policy_peer::serve(stack);
  dds_delete(DDS_CYCLONEDDS_HANDLE);
  return code;
}
