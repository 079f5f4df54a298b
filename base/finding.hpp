// Findings: remarks about a document or folder that is readable. Each refers to a rule with a
// stable id.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/code.hpp"

namespace ddssec {

/// Rules for documents and folders. Their ids, such as GOV012, never change. The lists are in
/// base/rules/*.def: X(id, severity, "what it is about", "what to do about it").
enum class Rule : std::uint8_t {
#define X(id, severity, title, hint) id,
#include "base/rules/all.def"
#undef X
  end_  ///< not a rule
};

/// One row of the table of rules.
struct RuleInfo {
  Rule rule;
  std::string_view id;
  Severity severity;
  std::string_view title;  ///< what it is about, without values
  std::string_view hint;   ///< what the user can do about it
};

/// Returns all rules, in the order of the lists.
std::span<const RuleInfo> all_rules();

/// Returns the row of `rule`.
const RuleInfo& info(Rule rule);

/// One violation of a rule in a document or folder.
struct Finding {
  Rule rule;
  std::string message;        ///< one sentence with the actual values
  std::string document = {};  ///< a path; empty if the caller knows the document
  int line = 0;               ///< from 1; 0 if there is none
  std::string path = {};      ///< place in the document, such as /dds/permissions/grant[2]
  std::string hint = {};      ///< empty if the rule's hint applies
  std::vector<std::string> products = {};  ///< products, such as "cyclonedds"; empty for all
  Severity severity = info(rule).severity;
};

}  // namespace ddssec
