// The report about the meeting of two participants, as text and as JSON.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/frame/answer.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// The directions that must work for topics.
enum class WantedDirections : std::uint8_t {
  any,       ///< one direction is enough, on every topic
  both,      ///< both directions must work
  writer_a,  ///< the first participant writes and the second reads
  writer_b,
};

inline constexpr std::string_view kSides[] = {"A", "B"}, kSideWords = "A|B";

template <>
struct FieldsOf<governance::doctor::PartyDecision> {
  using T = governance::doctor::PartyDecision;
  static constexpr std::string_view kDef = "judgement";
  static constexpr auto fields() {
    return std::tuple(
        computed<T>("from", [](const T& one) { return kSides[one.about]; }, {.words = kSideWords}),
        computed<T>("to", [](const T& one) { return kSides[one.judge]; }, {.words = kSideWords}),
        field<&T::ok>(), computed<T>("reason", [](const T& one) {
          return one.ok ? std::nullopt : std::optional(one.reason);
        }));
  }
};

template <>
struct FieldsOf<governance::doctor::Difference> {
  using T = governance::doctor::Difference;
  static constexpr std::string_view kDef = "difference";
  static constexpr auto fields() {
    return std::tuple(field<&T::element>(),
                      computed<T>("a", [](const T& one) { return one.values[0]; }),
                      computed<T>("b", [](const T& one) { return one.values[1]; }),
                      computed<T>("line_a", [](const T& one) { return one.lines[0]; }),
                      computed<T>("line_b", [](const T& one) { return one.lines[1]; }));
  }
};

/// The rule that decides a judgement about a topic.
struct DecidingRule {
  const governance::doctor::PartyDecision* by;

  static constexpr auto fields() {
    using T = DecidingRule;
    using By = governance::doctor::PartyDecision;
    return std::tuple(field("grant", &T::by, &By::grant), field("index", &T::by, &By::rule),
                      computed<T>("kind",
                                  [](const T& one) {
                                    return one.by->rule == 0       ? "default"
                                           : one.by->is_allow_rule ? "allow"
                                                                   : "deny";
                                  },
                                  {.words = "allow|deny|default"}),
                      field("expression", &T::by, &By::expression),
                      field("file", &T::by, &By::document), field("line", &T::by, &By::line));
  }
};

/// A judgement about a topic.
struct JudgementStep {
  const governance::doctor::PartyDecision* by;

  static constexpr auto fields() {
    using T = JudgementStep;
    using By = governance::doctor::PartyDecision;
    return std::tuple(computed<T>("judge", [](const T& one) { return kSides[one.by->judge]; },
                                  {.words = kSideWords}),
                      computed<T>("about", [](const T& one) { return kSides[one.by->about]; },
                                  {.words = kSideWords}),
                      field("op", &T::by, &By::operation, {.words = "publish|subscribe"}),
                      field("ok", &T::by, &By::ok), field("reason", &T::by, &By::reason),
                      computed<T>("rule", [](const T& one) { return DecidingRule{one.by}; }));
  }
};

/// The kinds of protection that one side's governance demands for a topic.
struct TopicProtection {
  ProtectionKind payload, metadata, rtps;

  static constexpr auto fields() {
    using T = TopicProtection;
    constexpr FieldOptions kKind{.def = "protection_kind"};
    return std::tuple(field<&T::payload>(kKind), field<&T::metadata>(kKind),
                      field<&T::rtps>(kKind));
  }
};

struct MeetingView;

/// A direction of a topic.
struct ShownDirection {
  static constexpr std::string_view kDef = "direction";
  const MeetingView* view;
  const governance::doctor::TopicMeeting* topic;
  const governance::doctor::TopicDirection* by;

  std::vector<JudgementStep> steps() const;
  std::optional<TopicProtection> protection() const;
  std::optional<std::string> obstacle() const;
  /// Returns the first reason why writer and reader do not match.
  std::optional<std::string> reason() const;

  static constexpr auto fields() {
    using T = ShownDirection;
    using By = governance::doctor::TopicDirection;
    constexpr FieldOptions kIfAny{.omits_empty = true};
    return std::tuple(
        computed<T>("writer", [](const T& one) { return kSides[one.by->writer]; },
                    {.words = kSideWords}),
        computed<T>("reader", [](const T& one) { return kSides[1 - one.by->writer]; },
                    {.words = kSideWords}),
        field("ok", &T::by, &By::ok), field<&T::steps>(),
        field("differences", &T::by, &By::differences), field<&T::protection>(kIfAny),
        field<&T::obstacle>(kIfAny),
        field<&T::reason>({.note = "the first thing that keeps them apart", .omits_empty = true}));
  }
};

/// One topic in the result of `doctor` for two folders. Borrows the view.
struct ShownTopic {
  const MeetingView* view;
  const governance::doctor::TopicMeeting* by;

  static constexpr auto fields() {
    using T = ShownTopic;
    using By = governance::doctor::TopicMeeting;
    return std::tuple(
        field("name", &T::by, &By::topic),
        computed<T>("expression",
                    [](const T& one) {
                      return one.by->expression.empty() ? std::nullopt
                                                        : std::optional(one.by->expression);
                    },
                    {"of the documents, of which `name` is only an example; null: none"}),
        computed<T>(
            "directions",
            [](const T& one) {
              const auto& [a, b] = one.by->directions;
              return std::vector<ShownDirection>{{one.view, one.by, &a}, {one.view, one.by, &b}};
            },
            {.has_own_row = true, .min = 2, .max = 2}));
  }
};

/// The judgement whether the two participants may be in one domain.
struct ShownJoin {
  DomainId domain;
  bool ok;
  std::vector<governance::doctor::PartyDecision> judgements;
  std::vector<governance::doctor::Difference> differences;
  std::vector<std::optional<std::string>> masks;

  static constexpr auto fields() {
    using T = ShownJoin;
    return std::tuple(field<&T::domain>(), field<&T::ok>(),
                      field<&T::judgements>({.note = "as `start`", .has_same_members = true}),
                      field<&T::differences>(),
                      field<&T::masks>({.def = "masks", .min = 2, .max = 2}));
  }
};

/// The handshake, and the side that starts it.
struct ShownHandshake {
  std::optional<std::string_view> starts;
  bool ok;

  static constexpr auto fields() {
    using T = ShownHandshake;
    return std::tuple(field<&T::starts>({.note = "null: by chance", .words = kSideWords}),
                      field<&T::ok>());
  }
};

/// A meeting and the way to present it: the result of `check`.
struct MeetingView {
  using Kept = std::shared_ptr<const governance::doctor::LoadedFolder>;
  governance::doctor::Meeting meeting;
  std::string names[2];
  DomainId domain = 0;
  bool topics_named = false;  ///< topics were named; otherwise one topic that works is enough
  WantedDirections wanted = WantedDirections::any;
  bool explain = false;  ///< show every judgement, not only those that decide
  Kept kept[2] = {};     ///< the folders with the documents that the meeting refers to

  /// True if they would communicate as wanted.
  bool talk() const;
  ShownJoin join() const;
  std::optional<ShownHandshake> handshake() const;
  std::vector<ShownTopic> topics() const;
  std::vector<std::string> vendor_notes() const;
  /// Returns the steps, the topics and a last line with the result.
  std::string text() const;

  static constexpr auto fields() {
    using T = MeetingView;
    using By = governance::doctor::Meeting;
    constexpr FieldOptions kSame{.note = "the same", .has_same_members = true};
    return std::tuple(field("start", &T::meeting, &By::start),
                      field("authentication", &T::meeting, &By::authentication, kSame),
                      field("permissions", &T::meeting, &By::permissions, kSame), field<&T::join>(),
                      field<&T::handshake>({"null: a certificate cannot be read"}),
                      field<&T::topics>(),
                      field("topics_complete", &T::meeting, &By::topics_complete),
                      field<&T::talk>(), field<&T::vendor_notes>());
  }
};

/// True if the participants communicate, but something else than permissions separates them on a
/// topic that both may use: governance documents that protect it differently, or the behaviour of a
/// product.
bool has_topic_apart(const governance::doctor::Meeting& meeting);

}  // namespace ddssec::cli
