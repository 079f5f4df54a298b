// The policy peer on Fast DDS.
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/ContentFilteredTopic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#if DDSSEC_FASTDDS >= 3
#include <fastdds/dds/xtypes/dynamic_types/DynamicType.hpp>
#include <fastdds/dds/xtypes/dynamic_types/DynamicTypeBuilder.hpp>
#include <fastdds/dds/xtypes/dynamic_types/DynamicTypeBuilderFactory.hpp>
#include <fastdds/dds/xtypes/dynamic_types/MemberDescriptor.hpp>
#include <fastdds/dds/xtypes/dynamic_types/TypeDescriptor.hpp>
#include <fastdds/dds/xtypes/type_representation/ITypeObjectRegistry.hpp>
#else
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#include <fastrtps/types/DynamicType.h>
#include <fastrtps/types/DynamicTypeBuilder.h>
#include <fastrtps/types/DynamicTypeBuilderFactory.h>
#include <fastrtps/types/DynamicTypeBuilderPtr.h>
#include <fastrtps/types/TypeObjectFactory.h>
#endif

#include "interop/peers/fastdds_shape.hpp"
#include "interop_rtps/policy_peer.hpp"

namespace {

using namespace interop_fast;
using policy_peer::End;
using policy_peer::Policies;

Duration_t milliseconds(std::int64_t count) {
  return Duration_t(static_cast<int32_t>(count / 1000),
                    static_cast<uint32_t>(count % 1000 * 1'000'000));
}

// Content filters of Fast DDS read samples through the type's description.
#if DDSSEC_FASTDDS >= 3
class DescribedShape final : public ShapeType {
  static const fdds::xtypes::TypeIdentifier& complete(const fdds::xtypes::TypeIdentifierPair& of) {
    const auto& first = of.type_identifier1();
    return first._d() == fdds::xtypes::EK_COMPLETE ? first : of.type_identifier2();
  }
  void register_type_object_representation() override {
    const auto factory = fdds::DynamicTypeBuilderFactory::get_instance();
    const auto shape = fdds::traits<fdds::TypeDescriptor>::make_shared();
    shape->kind(fdds::TK_STRUCTURE);
    shape->name(get_name());
    shape->extensibility_kind(fdds::ExtensibilityKind::FINAL);
    const auto builder = factory->create_type(shape);
    const auto add = [&](const char* name, const fdds::DynamicType::_ref_type& type) {
      const auto member = fdds::traits<fdds::MemberDescriptor>::make_shared();
      member->name(name);
      member->type(type);
      member->is_key(std::string_view(name) == "color");
      builder->add_member(member);
    };
    const auto number = factory->get_primitive_type(fdds::TK_INT32);
    add("color", factory->create_string_type(fdds::LENGTH_UNLIMITED)->build());
    for (const auto* name : {"x", "y", "shapesize"}) add(name, number);
    add("payload", factory
                       ->create_sequence_type(factory->get_primitive_type(fdds::TK_BYTE),
                                              fdds::LENGTH_UNLIMITED)
                       ->build());
    // A filter looks for the type by its name, but a dynamic type registers identifiers only.
    auto& registry = fdds::DomainParticipantFactory::get_instance()->type_object_registry();
    fdds::xtypes::TypeIdentifierPair unnamed;
    fdds::xtypes::TypeObject object;
    if (!ok(registry.register_typeobject_w_dynamic_type(builder->build(), unnamed)) ||
        !ok(registry.get_type_object(complete(unnamed), object)) ||
        !ok(registry.register_type_object(get_name(), object.complete(), type_identifiers_)))
      std::fprintf(stderr, "Fast DDS does not know its type\n");
  }
};

void describe_type() {}
#else
using DescribedShape = ShapeType;

void describe_type() {
  namespace types = eprosima::fastrtps::types;
  auto& factory = *types::DynamicTypeBuilderFactory::get_instance();
  auto* shape = factory.create_struct_builder();
  shape->set_name("interop::Shape");
  shape->add_member(0, "color", factory.create_string_type());
  shape->add_member(1, "x", factory.create_int32_type());
  shape->add_member(2, "y", factory.create_int32_type());
  shape->add_member(3, "shapesize", factory.create_int32_type());
  auto* octets = factory.create_sequence_builder(factory.create_byte_type(), 1024);
  shape->add_member(4, "payload", octets->build());
  types::TypeObject object;
  const auto type = shape->build();
  factory.build_type_object(type, object, true);
  const auto* id =
      types::TypeObjectFactory::get_instance()->get_type_identifier("interop::Shape", true);
  if (id == nullptr) std::fprintf(stderr, "Fast DDS does not know its type\n");
}
#endif

template <class Q>
void set_qos(Q& qos, const Policies& p) {
  qos.reliability().kind = p.is("reliability", "best_effort") ? fdds::BEST_EFFORT_RELIABILITY_QOS
                                                              : fdds::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = p.is("durability", "transient_local")
                              ? fdds::TRANSIENT_LOCAL_DURABILITY_QOS
                              : fdds::VOLATILE_DURABILITY_QOS;
  if (p.is("history", "all"))
    qos.history().kind = fdds::KEEP_ALL_HISTORY_QOS;
  else if (p.has("history"))
    qos.history().depth = static_cast<int32_t>(p.number("history"));
  if (p.has("deadline")) qos.deadline().period = milliseconds(p.number("deadline"));
  if (p.has("lifespan")) qos.lifespan().duration = milliseconds(p.number("lifespan"));
  if (p.is("liveliness", "participant"))
    qos.liveliness().kind = fdds::MANUAL_BY_PARTICIPANT_LIVELINESS_QOS;
  if (p.is("liveliness", "topic")) qos.liveliness().kind = fdds::MANUAL_BY_TOPIC_LIVELINESS_QOS;
  if (p.has("lease")) {
    qos.liveliness().lease_duration = milliseconds(p.number("lease"));
    qos.liveliness().announcement_period = milliseconds(p.number("lease") / 2);
  }
  if (p.is("ownership", "exclusive")) qos.ownership().kind = fdds::EXCLUSIVE_OWNERSHIP_QOS;
  if (p.has("budget")) qos.latency_budget().duration = milliseconds(p.number("budget"));
  const auto user = p.text("user");
  qos.user_data().assign(user.begin(), user.end());
  if (p.is("order", "source"))
    qos.destination_order().kind = fdds::BY_SOURCE_TIMESTAMP_DESTINATIONORDER_QOS;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  qos.data_sharing().off();
}

template <class Q>
void set_group(Q& group, const Policies& p) {
  if (p.has("partition")) group.partition().push_back(p.text("partition").c_str());
  const auto data = p.text("group");
  group.group_data().assign(data.begin(), data.end());
  group.entity_factory().autoenable_created_entities = !p.is("factory", "off");
}

// The last announcement of each kind of endpoint, by topic.
class Discovered final : public fdds::DomainParticipantListener {
 public:
#if DDSSEC_FASTDDS >= 3
  void on_data_writer_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryStatus,
                                const rtps::PublicationBuiltinTopicData& info, bool&) override {
    note("reader", info.topic_name.to_string(), info);
  }
  void on_data_reader_discovery(fdds::DomainParticipant*, rtps::ReaderDiscoveryStatus,
                                const rtps::SubscriptionBuiltinTopicData& info, bool&) override {
    note("writer", info.topic_name.to_string(), info);
  }
#else
  struct Data {
    const fdds::UserDataQosPolicy& user_data;
    const fdds::TopicDataQosPolicy& topic_data;
    const fdds::GroupDataQosPolicy& group_data;
  };
  template <class Qos>
  static Data data_in(const Qos& qos) {
    return {qos.m_userData, qos.m_topicData, qos.m_groupData};
  }
  void on_publisher_discovery(fdds::DomainParticipant*, rtps::WriterDiscoveryInfo&& info) override {
    note("reader", info.info.topicName().to_string(), data_in(info.info.m_qos));
  }
  void on_subscriber_discovery(fdds::DomainParticipant*,
                               rtps::ReaderDiscoveryInfo&& info) override {
    note("writer", info.info.topicName().to_string(), data_in(info.info.m_qos));
  }
#endif
  // Returns what was announced to a "reader" or "writer" (`to`).
  std::string told(const std::string& to, const std::string& topic) {
    const std::lock_guard held(mutex_);
    return told_[to + topic];
  }

 private:
  template <class Data>
  void note(const std::string& to, const std::string& topic, const Data& data) {
    const auto text = [](const auto& octets) {
      return std::string(octets.data_vec().begin(), octets.data_vec().end());
    };
    const std::lock_guard held(mutex_);
    told_[to + topic] = "user=" + text(data.user_data) + " topic=" + text(data.topic_data) +
                        " group=" + text(data.group_data);
  }
  std::mutex mutex_;
  std::map<std::string, std::string> told_;
};

class Fast final : public policy_peer::Stack {
 public:
  Fast(fdds::DomainParticipant& participant, const std::string& type, Discovered& discovered)
      : participant_(participant), type_(type), discovered_(discovered) {}

  bool writer(const std::string& id, const std::string& topic, const Policies& p) override {
    fdds::PublisherQos group = fdds::PUBLISHER_QOS_DEFAULT;
    set_group(group, p);
    fdds::DataWriterQos qos = fdds::DATAWRITER_QOS_DEFAULT;
    set_qos(qos, p);
    if (p.has("strength"))
      qos.ownership_strength().value = static_cast<uint32_t>(p.number("strength"));
    qos.writer_data_lifecycle().autodispose_unregistered_instances = p.is("autodispose", "on");
    set_heartbeat_period(qos, Duration_t(0, 100'000'000));
    auto* publisher = participant_.create_publisher(group);
    return (writers_[id] = publisher->create_datawriter(topic_of(topic, p), qos)) != nullptr;
  }
  bool reader(const std::string& id, const std::string& topic, const Policies& p) override {
    fdds::SubscriberQos group = fdds::SUBSCRIBER_QOS_DEFAULT;
    set_group(group, p);
    fdds::DataReaderQos qos = fdds::DATAREADER_QOS_DEFAULT;
    set_qos(qos, p);
    auto* subscriber = participant_.create_subscriber(group);
    fdds::TopicDescription* wanted = topic_of(topic, p);
    if (p.has("filter"))
      wanted = participant_.create_contentfilteredtopic("filtered_" + id, topic_of(topic, p),
                                                        p.text("filter"), {});
    return wanted != nullptr &&
           (readers_[id] = subscriber->create_datareader(wanted, qos)) != nullptr;
  }
  bool remove(const std::string& id) override {
    if (const auto at = writers_.find(id); at != writers_.end())
      return ok(
          const_cast<fdds::Publisher*>(at->second->get_publisher())->delete_datawriter(at->second));
    auto* reader = readers_.at(id);
    return ok(const_cast<fdds::Subscriber*>(reader->get_subscriber())->delete_datareader(reader));
  }
  bool write(const std::string& id, const std::string& color, int x, std::int64_t) override {
    Shape shape{.color = color, .x = x, .y = 2 * x};
    return ok(writers_.at(id)->write(&shape));
  }
  bool end(const std::string& id, const std::string& color, End how) override {
    Shape shape{.color = color};
    auto& writer = *writers_.at(id);
    return ok(how == End::dispose ? writer.dispose(&shape, rtps::InstanceHandle_t())
                                  : writer.unregister_instance(&shape, rtps::InstanceHandle_t()));
  }
  bool assert_liveliness(const std::string& id) override {
    return ok(writers_.at(id)->assert_liveliness());
  }
  bool enable(const std::string& id) override { return ok(writers_.at(id)->enable()); }
  std::string told(const std::string& id) override {
    if (const auto at = writers_.find(id); at != writers_.end())
      return discovered_.told("writer", at->second->get_topic()->get_name());
    return discovered_.told("reader", readers_.at(id)->get_topicdescription()->get_name());
  }
  std::string take(const std::string& id) override {
    std::ostringstream out;
    Shape shape;
    fdds::SampleInfo info;
    while (ok(readers_.at(id)->take_next_sample(&shape, &info))) {
      const auto state = info.instance_state == fdds::ALIVE_INSTANCE_STATE                ? 'A'
                         : info.instance_state == fdds::NOT_ALIVE_DISPOSED_INSTANCE_STATE ? 'D'
                                                                                          : 'N';
      // Without data, only the handle says which instance it is.
      auto& color = colors_[id][info.instance_handle];
      if (info.valid_data) color = shape.color;
      out << ' ' << (color.empty() ? "?" : color) << ':'
          << (info.valid_data ? std::to_string(shape.x) : "-") << ':' << state;
    }
    return out.str();
  }
  std::string status(const std::string& id) override {
    std::ostringstream out;
    if (const auto at = writers_.find(id); at != writers_.end()) {
      fdds::PublicationMatchedStatus matched;
      fdds::OfferedIncompatibleQosStatus qos;
      fdds::OfferedDeadlineMissedStatus deadline;
      fdds::LivelinessLostStatus lost;
      at->second->get_publication_matched_status(matched);
      at->second->get_offered_incompatible_qos_status(qos);
      at->second->get_offered_deadline_missed_status(deadline);
      at->second->get_liveliness_lost_status(lost);
      count(id, static_cast<int>(qos.last_policy_id));
      out << "matched=" << matched.current_count << " incompatible=" << incompatible_[id]
          << " deadline=" << deadline.total_count << " lost=" << lost.total_count;
    } else {
      auto& reader = *readers_.at(id);
      fdds::SubscriptionMatchedStatus matched;
      fdds::RequestedIncompatibleQosStatus qos;
      fdds::RequestedDeadlineMissedStatus deadline;
      fdds::LivelinessChangedStatus lives;
      reader.get_subscription_matched_status(matched);
      reader.get_requested_incompatible_qos_status(qos);
      reader.get_requested_deadline_missed_status(deadline);
      reader.get_liveliness_changed_status(lives);
      count(id, static_cast<int>(qos.last_policy_id));
      out << "matched=" << matched.current_count << " incompatible=" << incompatible_[id]
          << " deadline=" << deadline.total_count << " alive=" << lives.alive_count
          << " not_alive=" << lives.not_alive_count;
    }
    return out.str();
  }

 private:
  void count(const std::string& id, int policy) {
    if (policy != 0) incompatible_[id] = policy;
  }
  fdds::Topic* topic_of(const std::string& name, const Policies& p) {
    auto& topic = topics_[name];
    fdds::TopicQos qos = fdds::TOPIC_QOS_DEFAULT;
    const auto data = p.text("topic");
    qos.topic_data().assign(data.begin(), data.end());
    if (topic == nullptr) topic = participant_.create_topic(name, type_, qos);
    return topic;
  }

  fdds::DomainParticipant& participant_;
  const std::string type_;
  Discovered& discovered_;
  std::map<std::string, fdds::Topic*> topics_;
  std::map<std::string, fdds::DataWriter*> writers_;
  std::map<std::string, fdds::DataReader*> readers_;
  std::map<std::string, int> incompatible_;
  std::map<std::string, std::map<rtps::InstanceHandle_t, std::string>> colors_;
};

}  // namespace

int main() {
  log_to_stderr();
  fdds::DomainParticipantQos qos = fdds::PARTICIPANT_QOS_DEFAULT;
  set_loopback(qos);
  auto* factory = fdds::DomainParticipantFactory::get_instance();
  Discovered discovered;
  auto* participant = factory->create_participant(0, qos, &discovered, fdds::StatusMask::none());
  fdds::TypeSupport type(new DescribedShape);
  if (participant == nullptr || !ok(type.register_type(participant))) return 3;
  describe_type();
  Fast stack(*participant, type.get_type_name(), discovered);
  const int code = policy_peer::serve(stack);
  participant->delete_contained_entities();
  factory->delete_participant(participant);
  return code;
}
