#include "cli/doctor/meeting_report.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "plugins/access_control/protection.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
using doctor::Meeting;
using doctor::PartyDecision;
using doctor::TopicDirection;
using doctor::TopicMeeting;

bool works(const TopicMeeting& topic, WantedDirections wanted) {
  const bool a = topic.directions[0].ok;
  const bool b = topic.directions[1].ok;
  switch (wanted) {
    case WantedDirections::any:
      return a || b;
    case WantedDirections::both:
      return a && b;
    case WantedDirections::writer_a:
      return a;
    case WantedDirections::writer_b:
      return b;
  }
  return false;
}

std::string_view yes_or_no(bool ok) { return ok ? "ok" : "NO"; }

std::string place_of(const PartyDecision& judgement) {
  if (judgement.document.empty()) return {};
  const auto file = std::filesystem::path(judgement.document).filename().string();
  return judgement.line > 0 ? fmt::format(" ({}:{})", file, judgement.line)
                            : fmt::format(" ({})", file);
}

// For example "listener accepts talker: ok    talker accepts listener: ok".
std::string step_line(std::string_view title, const std::vector<PartyDecision>& judgements,
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
  const bool ok = std::ranges::all_of(meeting.join, &PartyDecision::ok);
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
  else if (!std::ranges::all_of(view.meeting.authentication, &doctor::PartyDecision::ok))
    outcome = "; the handshake fails (authentication: NO)";
  return fmt::format("{:<17}{}{}\n", "handshake", who, outcome);
}

std::string protection_of(const TopicMeeting& topic) {
  const auto* rule = topic.rules[0];
  if (rule == nullptr) return {};
  return fmt::format("   {} payload, {} metadata", to_string(rule->data_protection_kind),
                     to_string(rule->metadata_protection_kind));
}

std::string judgement_line(const PartyDecision& one, const MeetingView& view) {
  const auto who = one.judge == one.about
                       ? fmt::format("{}, locally", view.names[one.judge])
                       : fmt::format("{} about {}", view.names[one.judge], view.names[one.about]);
  return fmt::format("      {}: {}: {}{}\n", who, one.ok ? "allowed" : "REFUSED", one.reason,
                     place_of(one));
}

std::string reason_apart(const TopicDirection& direction, const MeetingView& view);

// The reason, unless the lines below already give it.
std::string reason_beside(const TopicDirection& direction, const MeetingView& view) {
  const bool is_below = view.explain || view.topics_named || !direction.differences.empty() ||
                        !direction.obstacle.reason.empty();
  return is_below ? std::string() : ": " + reason_apart(direction, view);
}

std::string direction_text(const TopicMeeting& topic, const TopicDirection& direction,
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

// A name that is only an example of an expression is in neither document, so the expression is
// shown first.
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

// True if the permissions allow the topic in one direction, but something else separates the
// participants: the protection, or the behaviour of a product.
bool is_kept_apart(const TopicMeeting& topic) {
  return is_idle(topic) && std::ranges::any_of(topic.directions, [](const TopicDirection& one) {
           return (!one.differences.empty() || !one.obstacle.reason.empty()) &&
                  std::ranges::all_of(one.steps, &PartyDecision::ok);
         });
}

bool protection_differs(const TopicMeeting& topic) {
  return std::ranges::any_of(topic.directions, [](const TopicDirection& one) {
    return !one.differences.empty() && std::ranges::all_of(one.steps, &PartyDecision::ok);
  });
}

// The first reason why a writer and a reader do not match. Empty if they match.
std::string reason_apart(const TopicDirection& direction, const MeetingView& view) {
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
  const auto refusals = [](const TopicDirection& one) {
    return std::ranges::count_if(one.steps, [](const PartyDecision& step) { return !step.ok; });
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

// For example "talker publishes to listener: rt/chatter".
std::string working_topics(const MeetingView& view, int writer) {
  constexpr std::size_t kMax = 5;
  std::size_t count = 0;
  std::size_t of_ros = 0;
  std::string names;
  for (const auto& topic : view.meeting.topics) {
    if (!topic.directions[writer].ok) continue;
    if (is_of_every_node(topic.topic)) {
      ++of_ros;
    } else if (++count <= kMax) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", words_of(topic));
    }
  }
  if (count > kMax) names += fmt::format(" and {} more", count - kMax);
  if (names.empty()) names = "nothing";
  if (of_ros > 0)
    names += fmt::format(" (and {} of every ROS 2 node)", count_text(of_ros, "topic"));
  return fmt::format("{} publishes to {}: {}", view.names[writer], view.names[1 - writer], names);
}

// For example "  not on Circle: listener may not subscribe to it: ...".
std::string topics_apart(const MeetingView& view) {
  constexpr std::size_t kMax = 5;
  std::size_t count = 0;
  std::string out;
  for (const bool is_wanted : {true, false})  // topics that both may use come first
    for (const auto& topic : view.meeting.topics) {
      if (!is_idle(topic) || is_kept_apart(topic) != is_wanted || is_of_every_node(topic.topic))
        continue;
      if (++count <= kMax)
        out += fmt::format("  not on {}: {}\n", words_of(topic), reason_apart(topic, view));
    }
  if (count > kMax) out += fmt::format("  nor on {} more\n", count_text(count - kMax, "topic"));
  return out;
}

std::string result_line(const MeetingView& view) {
  const auto& meeting = view.meeting;
  if (!meeting.joined()) return "result: they do not match\n";
  const bool differs = std::ranges::any_of(
      meeting.topics, [](const TopicMeeting& topic) { return protection_differs(topic); });
  const bool is_partial =
      std::ranges::find(meeting.notes, Rule::DOC099, &Finding::rule) != meeting.notes.end();
  const bool is_all_idle = std::ranges::all_of(meeting.topics, is_idle);
  const auto verdict =
      differs ? (is_all_idle ? "they authenticate, but no topic works: the protection differs"
                             : "they match, but the protection of a topic differs")
      : has_topic_apart(meeting)
          ? (is_all_idle ? "they authenticate, but no topic works: a product keeps them apart"
                         : "they match, but a product keeps them apart on a topic")
      : is_partial  ? "they match, but on some topics without partitions only"
      : is_all_idle ? (view.topics_named ? "they authenticate, but share none of these topics"
                       : !meeting.topics_complete
                           ? "they authenticate; whether they share a topic is not known"
                           : "they authenticate, but share no topic")
                    : "they match";
  return fmt::format("result: {}\n  {}\n  {}\n{}{}", verdict, working_topics(view, 0),
                     working_topics(view, 1), topics_apart(view),
                     meeting.topics_complete ? "" : "  (not every topic was looked at)\n");
}

}  // namespace

std::vector<JudgementStep> ShownDirection::steps() const {
  std::vector<JudgementStep> out;
  for (const auto& one : by->steps) out.push_back({&one});
  return out;
}

std::optional<TopicProtection> ShownDirection::protection() const {
  const auto* rule = topic->rules[by->writer];
  const auto* domain = view->meeting.rules[by->writer];
  if (rule == nullptr || domain == nullptr) return std::nullopt;
  return TopicProtection{rule->data_protection_kind, rule->metadata_protection_kind,
                         domain->rtps_protection_kind};
}

std::optional<std::string> ShownDirection::obstacle() const {
  const auto& reason = by->obstacle.reason;
  return reason.empty() ? std::nullopt : std::optional(reason);
}

std::optional<std::string> ShownDirection::reason() const {
  auto out = by->ok ? std::string() : reason_apart(*by, *view);
  return out.empty() ? std::nullopt : std::optional(std::move(out));
}

bool MeetingView::talk() const {
  if (!meeting.joined() || meeting.topics.empty()) return false;
  const auto good = [&](const TopicMeeting& topic) { return works(topic, wanted); };
  return topics_named || wanted != WantedDirections::any
             ? std::ranges::all_of(meeting.topics, good)
             : std::ranges::any_of(meeting.topics, good);
}

ShownJoin MeetingView::join() const {
  ShownJoin out{domain,
                std::ranges::all_of(meeting.join, &PartyDecision::ok),
                meeting.join,
                meeting.differences,
                {}};
  for (const auto* rule : meeting.rules)
    out.masks.push_back(rule != nullptr ? std::optional(mask_of(*rule)) : std::nullopt);
  return out;
}

std::optional<ShownHandshake> MeetingView::handshake() const {
  if (!meeting.starter) return std::nullopt;
  ShownHandshake out{{}, meeting.handshake_works};
  if (*meeting.starter != doctor::Starter::chance)
    out.starts = kSides[*meeting.starter == doctor::Starter::first ? 0 : 1];
  return out;
}

std::vector<ShownTopic> MeetingView::topics() const {
  std::vector<ShownTopic> out;
  for (const auto& one : meeting.topics) out.push_back({this, &one});
  return out;
}

std::vector<std::string> MeetingView::vendor_notes() const {
  std::vector<std::string> out;
  for (const auto& note : meeting.notes) out.push_back(note.message);
  return out;
}

std::string MeetingView::text() const {
  auto out = step_line("start", meeting.start, *this);
  if (!meeting.authentication.empty())
    out += step_line("authentication", meeting.authentication, *this) +
           step_line("permissions", meeting.permissions, *this) + join_line(*this) +
           handshake_line(*this);
  std::size_t hidden = 0;
  for (const auto& topic : meeting.topics) {
    if (is_idle(topic) && !is_kept_apart(topic) && !topics_named && !explain)
      hidden += meeting.joined() ? 1 : 0;
    else
      out += topic_text(topic, *this);
  }
  if (hidden > 0)
    out += fmt::format("and {} that only one of them may use (--explain shows them)\n",
                       count_text(hidden, "topic"));
  return out + result_line(*this);
}

bool has_topic_apart(const Meeting& meeting) {
  return meeting.joined() && std::ranges::any_of(meeting.topics, is_kept_apart);
}

}  // namespace ddssec::cli
