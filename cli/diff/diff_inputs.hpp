// The two documents that a diff compares, and functions to display their contents.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/fields.hpp"
#include "governance/compare/interpretations.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// One side of a comparison, without the parts that depend on the kind of document.
struct DiffSide {
  std::filesystem::path path;
  Bytes text = {};         ///< the XML document
  std::size_t octets = 0;  ///< the length of the whole file
  int first_line = 1;      ///< the line of the file on which the document begins
  bool is_signed = false;
  bool is_verified = false;
  /// The fingerprint of the signer's certificate if verified, otherwise the claimed one. Empty if
  /// the document is not signed.
  std::string signer = {};
  /// The time in the signature. It is verified together with the signer.
  std::optional<WallTime> signing_time = {};
};

/// The old and the new document.
struct DiffSides {
  DiffSide before, after;
};

/// Reads OLD and NEW; `document` finds the file if a participant's folder is given. Signed files
/// are verified if --ca is given, otherwise accepted without verification; unsigned XML is always
/// accepted. Errors: those of read_file, Certificate::bundle_from_pem and DocumentVerifier::verify.
Result<DiffSides> diff_sides(std::filesystem::path (*document)(const std::filesystem::path&),
                             const Arguments& arguments, const Context& context);

/// The signers, as a field list.
struct ShownSigners {
  static constexpr std::string_view kDef = "signer";
  struct VerifiedSides {
    bool old_side, new_side;

    static constexpr auto fields() {
      return std::tuple(field("old", &VerifiedSides::old_side),
                        field("new", &VerifiedSides::new_side));
    }
  };
  std::optional<std::string> old_side, new_side;
  bool same;
  VerifiedSides verified;

  static ShownSigners of(const DiffSides& sides);
  static constexpr auto fields() {
    using T = ShownSigners;
    return std::tuple(field("old", &T::old_side, {"null: not signed"}),
                      field("new", &T::new_side, {"null: not signed"}), field<&T::same>(),
                      field<&T::verified>());
  }
};
/// Returns complete lines: the signers, and whether they were verified. Empty if nothing is signed.
std::string signer_text(const DiffSides& sides);

/// Returns the value of --fail-on, if given. Error: usage.
Result<std::optional<std::string>> fail_on(const Arguments& arguments,
                                           const std::vector<std::string>& words);

/// Returns a line for each interpretation, under a heading. Empty if there are none.
std::string interpretations_text(const governance::Interpretations& interpretations);

/// One place that products interpret differently.
struct ShownInterpretation {
  std::string_view document;
  std::optional<std::string> expression;
  std::string sentence;
  bool widens;
  std::optional<std::string> at;

  static constexpr auto fields() {
    using T = ShownInterpretation;
    return std::tuple(field<&T::document>({.words = "old|new"}),
                      field<&T::expression>({"null: another construct"}), field<&T::sentence>(),
                      field<&T::widens>(), field<&T::at>());
  }
};

/// All such places, with the member `complete` if there may be more.
struct ShownInterpretations {
  static constexpr std::string_view kDef = "readings";
  std::vector<ShownInterpretation> all = {};
  bool complete;

  static ShownInterpretations of(const governance::Interpretations& interpretations,
                                 const DiffSides& sides);
  static constexpr auto fields() {
    using T = ShownInterpretations;
    return std::tuple(field<&T::all>(), field<&T::complete>());
  }
};

/// Returns the field "readings" of a comparison T, whose `diff` has the interpretations.
template <class T>
constexpr auto readings_field() {
  return computed<T>(
      "readings",
      [](const T& one) { return ShownInterpretations::of(one.diff.interpretations, one.sides); },
      {"what other products may read differently, and only one document has"});
}

/// Returns the text without control characters.
std::string escaped(std::string_view name);
/// Returns a name from a document, short and without control characters; "(empty name)" for "".
std::string name_text(std::string_view name);
/// Returns a text such as "a, b, c and 4 more", where each name is shown().
std::string names_text(const std::vector<std::string>& names);
/// Returns a text such as "domain 0" or "domains 0-4, 7".
std::string domains_text(const std::vector<governance::DomainRange>& domains);
/// Returns a text such as "  old:22 new:23". A line number of 0 is left out.
std::string lines_text(int old_line, int new_line);
/// Returns the text, or nothing if it is empty.
std::optional<std::string> if_any(std::string_view text);
/// Returns JSON such as [[0,4],[7,7]].
Json domains_json(const std::vector<governance::DomainRange>& domains);
/// Returns a text such as "file.xml:22". Empty without a line number.
std::optional<std::string> place(const std::filesystem::path& path, int line);

/// Returns the lines of one change: a heading and indented parts. Lines have at most 100 columns if
/// there are blanks to break them at.
std::string wrapped(std::string_view heading, const std::vector<std::string>& parts);

}  // namespace ddssec::cli
