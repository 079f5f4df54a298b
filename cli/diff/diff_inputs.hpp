// The two documents that a diff compares, and functions to display their contents.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "cli/frame/command.hpp"
#include "governance/compare/readings.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// One side of a comparison, without the parts that depend on the kind of document.
struct DiffSide {
  std::filesystem::path path;
  Bytes text = {};         ///< the XML document
  std::size_t octets = 0;  ///< of the whole file
  int first_line = 1;      ///< of the file, on which it begins
  bool is_signed = false;
  bool is_verified = false;
  /// The fingerprint of the signer's certificate if verified, otherwise the claimed one; empty: not
  /// signed.
  std::string signer = {};
};

struct DiffSides {
  DiffSide before, after;
};

/// Reads OLD and NEW; `document` finds the file if a participant's folder is given. Signed files
/// are verified if --ca is given, otherwise accepted without verification; unsigned XML is always
/// accepted. Errors: those of read_file, Certificate::bundle_from_pem and DocumentVerifier::verify.
Result<DiffSides> diff_sides(std::filesystem::path (*document)(const std::filesystem::path&),
                             const Arguments& arguments, const Context& context);

/// {"old", "new", "same", "verified"}.
Json signer_json(const DiffSides& sides);
/// Complete lines: the signer, and whether that was verified. Empty if nothing is signed.
std::string signer_text(const DiffSides& sides);

/// The value of --fail-on, if given. Error: usage.
Result<std::optional<std::string>> fail_on(const Arguments& arguments,
                                           const std::vector<std::string>& words);

/// A line for each reading, under a heading; empty without any.
std::string readings_text(const governance::Readings& readings);
/// {"all": [{"document", "expression", "sentence", "at"}], "complete"}
Json readings_json(const governance::Readings& readings, const DiffSides& sides);

/// The same without control characters.
std::string escaped(std::string_view name);
/// A name from a document, short and without control characters; "(empty name)" for "".
std::string shown(std::string_view name);
/// "a, b, c and 4 more", each shown().
std::string shown(const std::vector<std::string>& names);
/// "domain 0", "domains 0-4, 7".
std::string shown(const std::vector<governance::DomainRange>& domains);
/// "  old:22 new:23"; nothing for a line 0.
std::string shown_lines(int old_line, int new_line);
/// [[0,4],[7,7]]
Json domains_json(const std::vector<governance::DomainRange>& domains);
/// "file.xml:22", or null without a line.
Json place(const std::filesystem::path& path, int line);

/// The lines of one change: a heading and indented parts, at most 100 columns where there are
/// blanks.
std::string wrapped(std::string_view heading, const std::vector<std::string>& parts);

}  // namespace ddssec::cli
