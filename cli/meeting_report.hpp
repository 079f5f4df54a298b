// Two participants and what each makes of the other, for people and for programs.
#pragma once

#include "cli/report.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// What is asked of the topics.
enum class Wanted : std::uint8_t {
  any,       ///< one direction on every topic
  both,      ///< both directions
  writer_a,  ///< the first writes and the second reads
  writer_b,
};

/// How a meeting is looked at.
struct MeetingView {
  const governance::doctor::Meeting& meeting;
  std::string names[2];
  DomainId domain = 0;
  bool topics_named = false;  ///< the topics were asked for; else one that works is enough
  Wanted wanted = Wanted::any;
  bool explain = false;  ///< every judgement, not the deciding ones only
};

/// True if they would talk as wanted.
bool would_talk(const MeetingView& view);

/// Steps, topics and a last line with the result.
std::string meeting_text(const MeetingView& view);
/// True if they meet, and both may use a topic that something else keeps them apart on: governance
/// documents that protect it differently, or what a product does by itself.
bool has_topic_apart(const governance::doctor::Meeting& meeting);
/// authentication, permissions, join, handshake, topics, vendor_notes.
Json meeting_json(const MeetingView& view);

}  // namespace ddssec::cli
