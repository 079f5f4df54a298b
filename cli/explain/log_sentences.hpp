// Sentences about security, without a code, that Cyclone DDS and ROS 2 write to their logs.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace ddssec::cli {

/// A row of docs/sentences-of-cyclone-dds.md, or of the table of docs/secure-a-ros2-robot.md.
struct LogSentence {
  std::string_view sentence;  ///< "..." stands for names and numbers
  std::string_view meaning;
  std::string_view look_with;                ///< where to look next, such as a command
  std::string_view product = "Cyclone DDS";  ///< or "ROS 2"
};

/// Returns all sentences, in the order of the pages.
std::span<const LogSentence> log_sentences();

/// Returns the sentences that contain `text`, in any letter case, and those that are contained in
/// `text`, a line of a log. A text of fewer than four characters is contained in none.
std::vector<LogSentence> log_sentences_like(std::string_view text);

}  // namespace ddssec::cli
