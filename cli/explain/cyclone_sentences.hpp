// Sentences about security that Cyclone DDS itself writes to its log, without a code.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace ddssec::cli {

/// A row of docs/sentences-of-cyclone-dds.md.
struct CycloneSentence {
  std::string_view sentence;  ///< "..." stands for names and numbers
  std::string_view meaning;
  std::string_view look_with;  ///< where to look next, such as a command
};

/// Returns all sentences, in the order of the page.
std::span<const CycloneSentence> cyclone_sentences();

/// Returns the sentences that contain `text`, in any letter case, and those that are contained in
/// `text`, a line of a log. A text of fewer than four characters is contained in none.
std::vector<CycloneSentence> cyclone_sentences_like(std::string_view text);

}  // namespace ddssec::cli
