// The subjects of a comparison, as text and as JSON.
#pragma once

#include <string>

#include "cli/frame/report.hpp"
#include "governance/compare/grant_diff.hpp"

namespace ddssec::cli {

/// "domain 0", "domains 2-5, every tag but the empty one".
std::string shown(const governance::DomainScope& scope);
/// "topic rt/a", "topics rt/a*, rt/b* but not rt/bx* (e.g. rt/a)".
std::string shown(const governance::TopicSet& topics, const std::string& witness);
/// "in every partition but the default one (e.g. a)"; empty for the default partition alone.
std::string shown(const governance::EntityWords& entities);

/// {"form", "expressions", "examples"}
Json name_set_json(const governance::NameSet& set);
/// [{"expression", "also", "except", "more_exceptions"}] of the topics that are named.
Json topic_set_json(const governance::TopicSet& topics);
/// The tags of a scope; null if the documents name none.
Json tags_json(const governance::DomainScope& scope);

}  // namespace ddssec::cli
