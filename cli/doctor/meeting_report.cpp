#include "cli/doctor/meeting_report.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "plugins/access_control/protection.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::Direction;
using doctor::Judgement;
using doctor::Meeting;
using doctor::TopicMeeting;

constexpr const char* kSides[] = {"A", "B"};

bool works(const TopicMeeting& topic, Wanted wanted) {
  const bool a = topic.directions[0].ok;
  const bool b = topic.directions[1].ok;
  switch (wanted) {
    case Wanted::any:
      return a || b;
    case Wanted::both:
      return a && b;
    case Wanted::writer_a:
      return a;
    case Wanted::writer_b:
      return b;
  }
  return false;
}

std::string_view yes_or_no(bool ok) { return ok ? "ok" : "NO"; }

std::string place_of(const Judgement& judgement) {
  if (judgement.document.empty()) return {};
  const auto file = std::filesystem::path(judgement.document).filename().string();
  return judgement.line > 0 ? fmt::format(" ({}:{})", file, judgement.line)
                            : fmt::format(" ({})", file);
}

// "listener accepts talker: ok    talker accepts listener: ok".
std::string step_line(std::string_view title, const std::vector<Judgement>& judgements,
                      const MeetingView& view) {
  auto out = fmt::format("{:<17}", title);
  for (const auto& one : judgements)
    out += one.judge == one.about
               ? fmt::format("{} {}    ", view.names[one.about], yes_or_no(one.ok))
               : fmt::format("{} accepts {}: {}    ", view.names[one.judge], view.names[one.about],
                             yes_or_no(one.ok));
  return out.substr(0, out.find_last_not_of(' ') + 1) + '\n';
}

std::string mask_of(const governance::DomainRule& rule) {
  const auto info = spi::security_info(access_control::participant_attributes(rule));
  return fmt::format("0x{:08x}/0x{:08x}", info.mask, info.plugin_mask);
}

std::string join_line(const MeetingView& view) {
  const auto& meeting = view.meeting;
  const bool ok = std::ranges::all_of(meeting.join, &Judgement::ok);
  auto out = fmt::format("{:<17}domain {} {}", "join", view.domain, ok ? "ok (both)" : "NO");
  if (meeting.rules[0] != nullptr && meeting.rules[1] != nullptr)
    out += meeting.differences.empty()
               ? "    the governance documents agree on the domain"
               : fmt::format(
                     "    the governance documents DIFFER on the domain (attributes {} and {})",
                     mask_of(*meeting.rules[0]), mask_of(*meeting.rules[1]));
  return out + '\n';
}

std::string handshake_line(const MeetingView& view) {
  if (!view.meeting.starter) return {};
  const auto starter = *view.meeting.starter;
  const auto who =
      starter == doctor::Starter::chance
          ? std::string("either sends the first message, by chance")
          : view.names[starter == doctor::Starter::first ? 0 : 1] + " sends the first message";
  std::string_view outcome;
  if (!view.meeting.handshake_works)
    outcome = ": NO, if Fast DDS sends it these two products never finish the handshake";
  else if (!std::ranges::all_of(view.meeting.authentication, &doctor::Judgement::ok))
    outcome = "; the handshake fails (authentication: NO)";
  return fmt::format("{:<17}{}{}\n", "handshake", who, outcome);
}

std::string protection_of(const TopicMeeting& topic) {
  const auto* rule = topic.rules[0];
  if (rule == nullptr) return {};
  return fmt::format("   {} payload, {} metadata", to_string(rule->data_protection_kind),
                     to_string(rule->metadata_protection_kind));
}

std::string judgement_line(const Judgement& one, const MeetingView& view) {
  const auto who = one.judge == one.about
                       ? fmt::format("{}, locally", view.names[one.judge])
                       : fmt::format("{} about {}", view.names[one.judge], view.names[one.about]);
  return fmt::format("      {}: {}: {}{}\n", who, one.ok ? "allowed" : "REFUSED", one.reason,
                     place_of(one));
}

std::string reason_apart(const Direction& direction, const MeetingView& view);

// The reason, if the lines below do not give it.
std::string reason_beside(const Direction& direction, const MeetingView& view) {
  const bool is_below = view.explain || view.topics_named || !direction.differences.empty() ||
                        !direction.obstacle.reason.empty();
  return is_below ? std::string() : ": " + reason_apart(direction, view);
}

std::string direction_text(const TopicMeeting& topic, const Direction& direction,
                           const MeetingView& view) {
  auto out = fmt::format("  {} publishes -> {} subscribes   {}{}\n", view.names[direction.writer],
                         view.names[1 - direction.writer], direction.ok ? "YES" : "NO",
                         direction.ok ? protection_of(topic) : reason_beside(direction, view));
  for (const auto& step : direction.steps)
    if (view.explain || (view.topics_named && !step.ok)) out += judgement_line(step, view);
  for (const auto& difference : direction.differences)
    out += fmt::format("      <{}> is {} at {} and {} at {}\n", difference.element,
                       difference.values[0], view.names[0], difference.values[1], view.names[1]);
  if (!direction.obstacle.reason.empty())
    out += fmt::format("      {}\n", direction.obstacle.reason);
  return out;
}

std::string name_of(const TopicMeeting& topic) {
  return topic.topic.empty() ? "\"\"" : topic.topic;
}

// A name that is only an example of an expression is in neither document.
std::string words_of(const TopicMeeting& topic) {
  return topic.expression.empty() ? name_of(topic)
                                  : fmt::format("{} (e.g. {})", topic.expression, name_of(topic));
}

std::string topic_text(const TopicMeeting& topic, const MeetingView& view) {
  return fmt::format("{} {}\n", topic.expression.empty() ? "topic" : "topics", words_of(topic)) +
         direction_text(topic, topic.directions[0], view) +
         direction_text(topic, topic.directions[1], view);
}

bool is_idle(const TopicMeeting& topic) {
  return !topic.directions[0].ok && !topic.directions[1].ok;
}

// True if the permissions allow the topic in one direction, and something else separates the
// participants: the protection, or the behaviour of a product.
bool is_kept_apart(const TopicMeeting& topic) {
  return is_idle(topic) && std::ranges::any_of(topic.directions, [](const Direction& one) {
           return (!one.differences.empty() || !one.obstacle.reason.empty()) &&
                  std::ranges::all_of(one.steps, &Judgement::ok);
         });
}

bool protection_differs(const TopicMeeting& topic) {
  return std::ranges::any_of(topic.directions, [](const Direction& one) {
    return !one.differences.empty() && std::ranges::all_of(one.steps, &Judgement::ok);
  });
}

// The first reason why a writer and a reader do not match; "" if they do.
std::string reason_apart(const Direction& direction, const MeetingView& view) {
  for (const auto& one : direction.steps) {
    if (one.ok) continue;
    const auto* may = one.operation == "publish" ? "publish" : "subscribe to";
    return one.judge == one.about
               ? fmt::format("{} may not {} it: {}{}", view.names[one.about], may, one.reason,
                             place_of(one))
               : fmt::format("{} does not let {} {} it: {}{}", view.names[one.judge],
                             view.names[one.about], may, one.reason, place_of(one));
  }
  for (const auto& one : direction.differences)
    return fmt::format("<{}> is {} at {} and {} at {}", one.element, one.values[0], view.names[0],
                       one.values[1], view.names[1]);
  return direction.obstacle.reason;
}

// The reason for the direction that comes closest to working.
std::string reason_apart(const TopicMeeting& topic, const MeetingView& view) {
  const auto refusals = [](const Direction& one) {
    return std::ranges::count_if(one.steps, [](const Judgement& step) { return !step.ok; });
  };
  const auto nearest = refusals(topic.directions[1]) < refusals(topic.directions[0]) ? 1 : 0;
  return reason_apart(topic.directions[nearest], view);
}

// The topics that every ROS 2 node has besides its own.
bool is_of_every_node(std::string_view topic) {
  return topic == "ros_discovery_info" || topic == "rt/rosout" || topic == "rt/parameter_events" ||
         ((topic.starts_with("rq/") || topic.starts_with("rr/")) &&
          (topic.contains("/get_parameter") || topic.contains("/set_parameters") ||
           topic.contains("/list_parameters") || topic.contains("/describe_parameters")));
}

// "talker publishes to listener: rt/chatter".
std::string working_topics(const MeetingView& view, int writer) {
  constexpr std::size_t kMost = 5;
  std::size_t count = 0;
  std::size_t of_ros = 0;
  std::string names;
  for (const auto& topic : view.meeting.topics) {
    if (!topic.directions[writer].ok) continue;
    if (is_of_every_node(topic.topic)) {
      ++of_ros;
    } else if (++count <= kMost) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", words_of(topic));
    }
  }
  if (count > kMost) names += fmt::format(" and {} more", count - kMost);
  if (names.empty()) names = "nothing";
  if (of_ros > 0) names += fmt::format(" (and {} of every ROS 2 node)", counted(of_ros, "topic"));
  return fmt::format("{} publishes to {}: {}", view.names[writer], view.names[1 - writer], names);
}

// "  not on Circle: listener may not subscribe to it: ...".
std::string topics_apart(const MeetingView& view) {
  constexpr std::size_t kMost = 5;
  std::size_t count = 0;
  std::string out;
  for (const bool is_wanted : {true, false})  // those that both may use come first
    for (const auto& topic : view.meeting.topics) {
      if (!is_idle(topic) || is_kept_apart(topic) != is_wanted || is_of_every_node(topic.topic))
        continue;
      if (++count <= kMost)
        out += fmt::format("  not on {}: {}\n", words_of(topic), reason_apart(topic, view));
    }
  if (count > kMost) out += fmt::format("  nor on {} more\n", counted(count - kMost, "topic"));
  return out;
}

std::string result_line(const MeetingView& view) {
  const auto& meeting = view.meeting;
  if (!meeting.joined()) return "result: they do not match\n";
  const bool differs = std::ranges::any_of(
      meeting.topics, [](const TopicMeeting& topic) { return protection_differs(topic); });
  const bool is_partial =
      std::ranges::find(meeting.notes, Rule::DOC099, &Finding::rule) != meeting.notes.end();
  const auto verdict =
      differs                    ? "they match, but the protection of a topic differs"
      : has_topic_apart(meeting) ? "they match, but a product keeps them apart on a topic"
      : is_partial               ? "they match, but on some topics without partitions only"
      : std::ranges::all_of(meeting.topics, is_idle)
          ? (view.topics_named ? "they authenticate, but share none of these topics"
             : !meeting.topics_complete
                 ? "they authenticate; whether they share a topic is not known"
                 : "they authenticate, but share no topic")
          : "they match";
  return fmt::format("result: {}\n  {}\n  {}\n{}{}", verdict, working_topics(view, 0),
                     working_topics(view, 1), topics_apart(view),
                     meeting.topics_complete ? "" : "  (not every topic was looked at)\n");
}

Json reason_of(const Judgement& one) { return one.ok ? Json() : Json(one.reason); }

Json judgements_json(const std::vector<Judgement>& judgements) {
  Json out = Json::array();
  for (const auto& one : judgements)
    out.push_back({{"from", kSides[one.about]},
                   {"to", kSides[one.judge]},
                   {"ok", one.ok},
                   {"reason", reason_of(one)}});
  return out;
}

Json step_json(const Judgement& one) {
  Json out = {{"judge", kSides[one.judge]},
              {"about", kSides[one.about]},
              {"op", one.operation},
              {"ok", one.ok},
              {"reason", one.reason}};
  out["rule"] = {{"grant", one.grant},
                 {"index", one.rule},
                 {"kind", one.rule == 0       ? "default"
                          : one.is_allow_rule ? "allow"
                                              : "deny"},
                 {"expression", one.expression},
                 {"file", one.document},
                 {"line", one.line}};
  return out;
}

Json differences_json(const std::vector<doctor::Difference>& differences) {
  Json out = Json::array();
  for (const auto& one : differences)
    out.push_back({{"element", one.element},
                   {"a", one.values[0]},
                   {"b", one.values[1]},
                   {"line_a", one.lines[0]},
                   {"line_b", one.lines[1]}});
  return out;
}

Json direction_json(const TopicMeeting& topic, const Direction& direction,
                    const MeetingView& view) {
  Json out = {{"writer", kSides[direction.writer]},
              {"reader", kSides[1 - direction.writer]},
              {"ok", direction.ok},
              {"steps", Json::array()},
              {"differences", differences_json(direction.differences)}};
  for (const auto& step : direction.steps) out["steps"].push_back(step_json(step));
  const auto* rule = topic.rules[direction.writer];
  const auto* domain = view.meeting.rules[direction.writer];
  if (rule != nullptr && domain != nullptr)
    out["protection"] = {{"payload", to_string(rule->data_protection_kind)},
                         {"metadata", to_string(rule->metadata_protection_kind)},
                         {"rtps", to_string(domain->rtps_protection_kind)}};
  if (!direction.obstacle.reason.empty()) out["obstacle"] = direction.obstacle.reason;
  if (!direction.ok)
    if (const auto reason = reason_apart(direction, view); !reason.empty()) out["reason"] = reason;
  return out;
}

Json join_json(const MeetingView& view) {
  const auto& meeting = view.meeting;
  Json out = {{"domain", view.domain},
              {"ok", std::ranges::all_of(meeting.join, &Judgement::ok)},
              {"judgements", judgements_json(meeting.join)},
              {"differences", differences_json(meeting.differences)},
              {"masks", Json::array()}};
  for (const auto* rule : meeting.rules)
    out["masks"].push_back(rule != nullptr ? Json(mask_of(*rule)) : Json());
  return out;
}

Json handshake_json(const Meeting& meeting) {
  if (!meeting.starter) return nullptr;
  const auto starter = *meeting.starter;
  return {{"starts", starter == doctor::Starter::chance  ? Json()
                     : starter == doctor::Starter::first ? Json("A")
                                                         : Json("B")},
          {"ok", meeting.handshake_works}};
}

}  // namespace

bool would_talk(const MeetingView& view) {
  const auto& topics = view.meeting.topics;
  if (!view.meeting.joined() || topics.empty()) return false;
  const auto good = [&](const TopicMeeting& topic) { return works(topic, view.wanted); };
  return view.topics_named || view.wanted != Wanted::any ? std::ranges::all_of(topics, good)
                                                         : std::ranges::any_of(topics, good);
}

std::string meeting_text(const MeetingView& view) {
  const auto& meeting = view.meeting;
  auto out = step_line("start", meeting.start, view);
  if (!meeting.authentication.empty())
    out += step_line("authentication", meeting.authentication, view) +
           step_line("permissions", meeting.permissions, view) + join_line(view) +
           handshake_line(view);
  std::size_t hidden = 0;
  for (const auto& topic : meeting.topics) {
    if (is_idle(topic) && !is_kept_apart(topic) && !view.topics_named && !view.explain)
      hidden += meeting.joined() ? 1 : 0;
    else
      out += topic_text(topic, view);
  }
  if (hidden > 0)
    out += fmt::format("and {} that only one of them may use (--explain shows them)\n",
                       counted(hidden, "topic"));
  return out + result_line(view);
}

bool has_topic_apart(const Meeting& meeting) {
  return meeting.joined() && std::ranges::any_of(meeting.topics, is_kept_apart);
}

Json meeting_json(const MeetingView& view) {
  const auto& meeting = view.meeting;
  Json out = {{"start", judgements_json(meeting.start)},
              {"authentication", judgements_json(meeting.authentication)},
              {"permissions", judgements_json(meeting.permissions)},
              {"join", join_json(view)},
              {"handshake", handshake_json(meeting)},
              {"topics", Json::array()},
              {"topics_complete", meeting.topics_complete},
              {"talk", would_talk(view)},
              {"vendor_notes", Json::array()}};
  for (const auto& topic : meeting.topics)
    out["topics"].push_back(
        {{"name", topic.topic},
         {"expression", topic.expression.empty() ? Json() : Json(topic.expression)},
         {"directions",
          {direction_json(topic, topic.directions[0], view),
           direction_json(topic, topic.directions[1], view)}}});
  for (const auto& note : meeting.notes) out["vendor_notes"].push_back(note.message);
  return out;
}

}  // namespace ddssec::cli
