// The policy peer on the embedded participant. Options: "appendable" for a type of this kind;
// "memory FOLDER" for a secured participant with samples that are large enough for shared memory.
#include <thread>

#include "appendable_shape.hpp"
#include "base/rate_limited_sink.hpp"
#include "interop_rtps/policy_peer.hpp"
#include "secured/participant.hpp"
#include "shape.hpp"

namespace ddssec::rtps {

namespace {

using policy_peer::End;
using policy_peer::Policies;

Duration milliseconds(std::int64_t count) {
  return Duration::from(std::chrono::milliseconds(count));
}

Qos qos_of(const Policies& p) {
  Qos qos;
  qos.reliability.kind =
      p.is("reliability", "best_effort") ? ReliabilityKind::best_effort : ReliabilityKind::reliable;
  if (p.is("durability", "transient_local")) qos.durability = DurabilityKind::transient_local;
  if (p.is("durability", "transient")) qos.durability = DurabilityKind::transient;
  if (p.has("service"))
    qos.durability_service.history.depth = static_cast<std::int32_t>(p.number("service"));
  if (p.has("budget")) qos.latency_budget = milliseconds(p.number("budget"));
  if (p.has("priority")) qos.transport_priority = static_cast<std::int32_t>(p.number("priority"));
  qos.user_data = to_bytes(as_bytes(p.text("user")));
  if (p.is("history", "all"))
    qos.history.kind = HistoryKind::keep_all;
  else if (p.has("history"))
    qos.history.depth = static_cast<std::int32_t>(p.number("history"));
  if (p.has("deadline")) qos.deadline = milliseconds(p.number("deadline"));
  if (p.has("lifespan")) qos.lifespan = milliseconds(p.number("lifespan"));
  if (p.is("liveliness", "participant"))
    qos.liveliness.kind = LivelinessKind::manual_by_participant;
  if (p.is("liveliness", "topic")) qos.liveliness.kind = LivelinessKind::manual_by_topic;
  if (p.has("lease")) qos.liveliness.lease_duration = milliseconds(p.number("lease"));
  if (p.is("ownership", "exclusive")) qos.ownership = OwnershipKind::exclusive;
  if (p.has("strength")) qos.ownership_strength = static_cast<std::int32_t>(p.number("strength"));
  if (p.is("order", "source")) qos.destination_order = DestinationOrderKind::by_source;
  if (p.is("representation", "2")) qos.data_representation = {DataRepresentation::xcdr2};
  if (p.is("types", "same"))
    qos.type_consistency.kind = TypeConsistencyKind::disallow_type_coercion;
  qos.type_consistency.force_type_validation = p.has("types");
  if (p.has("separation")) qos.time_based_filter = milliseconds(p.number("separation"));
  if (p.has("samples"))
    qos.resource_limits.max_samples = static_cast<std::int32_t>(p.number("samples"));
  qos.autodispose_unregistered_instances = p.is("autodispose", "on");
  if (p.has("purge"))
    qos.reader_data_lifecycle.autopurge_disposed_samples_delay = milliseconds(p.number("purge"));
  return qos;
}

GroupQos group_of(const Policies& p) {
  GroupQos group;
  if (p.has("partition")) group.partition = {p.text("partition")};
  if (p.is("scope", "topic")) group.presentation.scope = PresentationScope::topic;
  if (p.is("scope", "group")) group.presentation.scope = PresentationScope::group;
  group.presentation.coherent_access = p.is("coherent", "on");
  group.group_data = to_bytes(as_bytes(p.text("group")));
  group.autoenable_created_entities = !p.is("factory", "off");
  return group;
}

template <DdsType Shape>
class Embedded final : public policy_peer::Stack {
 public:
  Embedded(DomainParticipant& participant, std::size_t more)
      : participant_(participant), more_(more) {}

  bool writer(const std::string& id, const std::string& topic, const Policies& p) override {
    auto& group = participant_.create_publisher(group_of(p));
    const auto made = group.template create_datawriter<Shape>(topic_of(topic, p), qos_of(p));
    if (made) writers_[id] = *made;
    return made.has_value();
  }
  bool reader(const std::string& id, const std::string& topic, const Policies& p) override {
    auto& group = participant_.create_subscriber(group_of(p));
    const auto made =
        p.has("filter") ? group.template create_datareader<Shape>(filtered(id, topic, p), qos_of(p))
                        : group.template create_datareader<Shape>(topic_of(topic, p), qos_of(p));
    if (made) readers_[id] = *made;
    return made.has_value();
  }
  bool remove(const std::string& id) override {
    if (const auto at = writers_.find(id); at != writers_.end())
      return at->second->publisher().delete_datawriter(*at->second).has_value();
    auto& reader = *readers_.at(id);
    return reader.subscriber().delete_datareader(reader).has_value();
  }
  bool write(const std::string& id, const std::string& color, int x,
             std::int64_t source_ms) override {
    const Shape shape{color, x, 2 * x, 30, filling()};
    auto& writer = *writers_.at(id);
    if (more_ > 0) warm_up(id, writer, source_ms);
    return write_at(writer, shape, source_ms);
  }
  bool end(const std::string& id, const std::string& color, End how) override {
    auto& writer = *writers_.at(id);
    Shape shape;
    shape.color = color;
    return (how == End::dispose ? writer.dispose(shape) : writer.unregister_instance(shape))
        .has_value();
  }
  bool assert_liveliness(const std::string& id) override {
    auto& writer = *writers_.at(id);
    return writer.assert_liveliness().has_value();
  }
  bool enable(const std::string& id) override { return writers_.at(id)->enable().has_value(); }
  std::string told(const std::string& id) override {
    const auto data_of = [](const auto& remotes, const auto& ask) {
      return remotes.empty() ? Qos{} : ask(remotes.front())->qos;
    };
    const auto writer = writers_.find(id);
    const auto qos =
        writer != writers_.end()
            ? data_of(writer->second->matched_subscriptions(),
                      [&](const Guid& g) { return writer->second->matched_subscription_data(g); })
            : data_of(readers_.at(id)->matched_publications(),
                      [&](const Guid& g) { return readers_.at(id)->matched_publication_data(g); });
    const auto text = [](const Bytes& octets) { return std::string(as_text(octets)); };
    return "user=" + text(qos.user_data) + " topic=" + text(qos.topic_data) +
           " group=" + text(qos.group_data);
  }
  std::string take(const std::string& id) override {
    Samples<Shape> samples;
    std::string out;
    if (!readers_.at(id)->take(samples)) return " refused";
    for (const auto& [data, info] : samples)
      if (data.color != kWarm)
        out += " " + data.color + ":" + (info.valid_data ? std::to_string(data.x) : "-") + ":" +
               (info.instance_state == InstanceState::alive                ? "A"
                : info.instance_state == InstanceState::not_alive_disposed ? "D"
                                                                           : "N");
    return out;
  }
  std::string status(const std::string& id) override {
    std::ostringstream out;
    if (const auto at = writers_.find(id); at != writers_.end()) {
      auto& writer = *at->second;
      describe(out, writer.publication_matched_status(), writer.offered_incompatible_qos_status(),
               writer.offered_deadline_missed_status());
      out << " lost=" << writer.liveliness_lost_status().total_count;
      return out.str();
    }
    auto& reader = *readers_.at(id);
    describe(out, reader.subscription_matched_status(), reader.requested_incompatible_qos_status(),
             reader.requested_deadline_missed_status());
    const auto lives = reader.liveliness_changed_status();
    out << " samples_lost=" << reader.sample_lost_status().total_count;
    out << " alive=" << lives.alive_count << " not_alive=" << lives.not_alive_count
        << " rejected=" << reader.sample_rejected_status().total_count;
    return out.str();
  }

  bool begin_set(const std::string& id) override {
    return writers_.at(id)->publisher().begin_coherent_changes().has_value();
  }
  bool end_set(const std::string& id) override {
    return writers_.at(id)->publisher().end_coherent_changes().has_value();
  }

 private:
  static constexpr const char* kWarm = "~warm";
  decltype(Shape::payload) filling() const { return decltype(Shape::payload)(more_, 0x5a); }
  static bool write_at(DataWriter<Shape>& writer, const Shape& shape, std::int64_t source_ms) {
    if (source_ms < 0) return writer.write(shape).has_value();
    return writer.write_w_timestamp(shape, {}, Time::from(std::chrono::milliseconds(source_ms)))
        .has_value();
  }
  // The first samples after a match are sent by UDP. These are such samples, which no scenario
  // sees.
  void warm_up(const std::string& id, DataWriter<Shape>& writer, std::int64_t source_ms) {
    const auto readers = writer.publication_matched_status().total_count;
    if (readers == 0 || std::exchange(warm_[id], readers) == readers) return;
    for (int i = 0; i < 5; ++i) {
      write_at(writer, {kWarm, 1, 2, 30, filling()}, source_ms < 0 ? source_ms : i);
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
    }
  }
  static void describe(std::ostream& out, const MatchedStatus& matched,
                       const IncompatibleQosStatus& qos, const DeadlineMissedStatus& deadline) {
    out << "matched=" << matched.current_count
        << " incompatible=" << static_cast<int>(qos.last_policy_id)
        << " deadline=" << deadline.total_count;
    if (!qos.last.policy.empty())
      std::cerr << qos.last.policy << ": offered " << qos.last.offered << ", requested "
                << qos.last.requested << "\n";
  }
  Topic& topic_of(const std::string& name, const Policies& p) {
    if (auto* known = participant_.lookup_topicdescription(name)) return *known;
    auto support = type_support<Shape>();
    if (p.is("describe", "no")) support.description = {};
    Qos qos;
    qos.topic_data = to_bytes(as_bytes(p.text("topic")));
    return **participant_.create_topic(name, std::move(support), qos);
  }

  ContentFilteredTopic& filtered(const std::string& id, const std::string& topic,
                                 const Policies& p) {
    return **participant_.create_contentfilteredtopic("filtered_" + id, topic_of(topic, p),
                                                      {p.text("filter")});
  }

  DomainParticipant& participant_;
  const std::size_t more_;  // octets in each sample
  std::map<std::string, std::int32_t> warm_;
  std::map<std::string, DataWriter<Shape>*> writers_;
  std::map<std::string, DataReader<Shape>*> readers_;
};

class StderrSink final : public EventSink {
 public:
  void raise(const Event& event) override { std::fprintf(stderr, "%s\n", event.to_line().c_str()); }
};

int run_secured(const char* folder) {
  auto participant = secured::or_exit(secured::Participant::join(folder, {.domain_id = 3}));
  Embedded<interop::Shape> stack(participant.dds(), 20'000);
  return policy_peer::serve(stack);
}

int run(bool appendable) {
  const SystemClock clock;
  SystemRandom random;
  StderrSink log;
  RateLimitedSink events(log, clock);
  const auto participant = DomainParticipant::create(
      {.interfaces = {"127.0.0.1"}, .multicast = false}, PluginServices{clock, random, events});
  if (!participant) return 3;
  if (appendable) {
    Embedded<growing::Shape> stack(**participant, 0);
    return policy_peer::serve(stack);
  }
  Embedded<interop::Shape> stack(**participant, 0);
  return policy_peer::serve(stack);
}

}  // namespace
}  // namespace ddssec::rtps

int main(int argc, char** argv) {
  if (argc == 3) return ddssec::rtps::run_secured(argv[2]);
  return ddssec::rtps::run(argc > 1);
}
