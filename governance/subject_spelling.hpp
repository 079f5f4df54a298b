// Judges how a grant's subject name is written: which stock products recognise a certificate by it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// A problem with the spelling of a subject, and the products that it affects.
struct SpellingProblem {
  std::string message = {};
  std::string right = {};  ///< what to write; empty if no text is right for all
  std::vector<std::string> products = {};
};

/// Returns the stock products that do not apply the grant to a certificate with this subject, given
/// once as Certificate::subject writes it and once in UTF-8. Versions: Cyclone DDS 0.10, Fast DDS
/// 2.9.
std::vector<std::string> not_recognising(const Grant& grant, std::string_view subject,
                                         std::string_view in_utf8);

/// Finds the problem of a subject name that cannot be read as a name, or that some stock product
/// does not recognise although it means the subject `right`. Names with letters beyond ASCII are
/// left out, and so are expressions.
std::optional<SpellingProblem> misspelt(const Grant& grant);

/// Finds the problem of a subject name with letters beyond ASCII: stock products recognise
/// different spellings of it.
std::optional<SpellingProblem> letters_beyond_ascii(const Grant& grant);

/// Explains what is wrong with a name that has Grant::subject_has_line_breaks.
std::string between_line_breaks(const std::string& subject);

}  // namespace ddssec::governance
