// Sentences about security that Cyclone DDS itself writes into its log, which have no code.
#pragma once

#include <span>
#include <string_view>
#include <vector>

namespace ddssec::cli {

/// A row of docs/sentences-of-cyclone-dds.md.
struct CycloneSentence {
  std::string_view sentence;  ///< "..." stands for names and numbers
  std::string_view meaning;
  std::string_view look_with;  ///< the command that says more
};

/// All of them, in the order of the page.
std::span<const CycloneSentence> cyclone_sentences();

/// Those of which `text` is a part, in any letter case, and those that are in `text`, a line of a
/// log. Fewer than four characters are part of none.
std::vector<CycloneSentence> cyclone_sentences_like(std::string_view text);

}  // namespace ddssec::cli
