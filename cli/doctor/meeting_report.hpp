// The report about the meeting of two participants, as text and as JSON.
#pragma once

#include "cli/frame/report.hpp"
#include "governance/doctor/meeting.hpp"

namespace ddssec::cli {

/// The required directions for topics.
enum class Wanted : std::uint8_t {
  any,       ///< one direction on every topic
  both,      ///< both directions
  writer_a,  ///< the first writes and the second reads
  writer_b,
};

/// A meeting and the way to present it.
struct MeetingView {
  const governance::doctor::Meeting& meeting;
  std::string names[2];
  DomainId domain = 0;
  bool topics_named = false;  ///< the topics were named; otherwise one that works is enough
  Wanted wanted = Wanted::any;
  bool explain = false;  ///< show every judgement, not only the deciding ones
};

/// True if they would communicate as wanted.
bool would_talk(const MeetingView& view);

/// Steps, topics and a last line with the result.
std::string meeting_text(const MeetingView& view);
/// True if they meet, and both may use a topic on which something else separates them: governance
/// documents that protect it differently, or the behaviour of a product.
bool has_topic_apart(const governance::doctor::Meeting& meeting);
/// authentication, permissions, join, handshake, topics, vendor_notes.
Json meeting_json(const MeetingView& view);

}  // namespace ddssec::cli
