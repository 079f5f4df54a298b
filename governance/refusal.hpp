// Why no rule of a grant lets an endpoint in, and what to change: for the person who reads it.
#pragma once

#include <string>

#include "governance/decision.hpp"

namespace ddssec::governance {

/// What a person should know about a refusal besides the line that decides.
struct RefusalAdvice {
  std::string because = {};  ///< a clause, or empty
  std::string hint = {};     ///< what to do; empty = what is always said
};

/// Where an allowing element holds, as a clause: "only in \"yard*\"", "only without a partition (or
/// in
/// \"\")"; empty if in every partition.
std::string partitions_of(const Criteria& criteria);

/// Of an endpoint that `verdict` refuses: whether an allow_rule has its topic, and only its
/// partitions or data tags keep it out. Nothing if a deny_rule refuses. Cheap: a peer may ask
/// often.
RefusalAdvice advice_on_endpoint(const CompiledGrant& grant, Action action, const Request& request,
                                 const Verdict& verdict);

/// Of a topic that no rule names: whether its name is close to one that an allow_rule has (a typo,
/// another case, the prefix of ROS 2 missing). Compares many names: not for what a peer asks.
RefusalAdvice advice_on_name(const CompiledGrant& grant, Action action, std::string_view topic);

/// Both: the second where the first has nothing to say and no rule decided.
RefusalAdvice advice_on(const CompiledGrant& grant, Action action, const Request& request,
                        const Verdict& verdict);

}  // namespace ddssec::governance
