#include "plugins/access_control/refusals.hpp"

#include <fmt/format.h>

#include "governance/refusal_advice.hpp"

namespace ddssec::access_control {
namespace {

using governance::Action;
using governance::CompiledGrant;
using governance::Decision;

// Shortens a name for events, because a peer may send a long one.
std::string shortened(std::string_view text) {
  constexpr std::size_t kMax = 256;
  return text.size() <= kMax ? std::string(text) : std::string(text.substr(0, kMax)) + "...";
}

std::string shown(const spi::EndpointRequest& request) {
  std::string text = fmt::format("topic \"{}\"", shortened(request.topic_name));
  constexpr std::size_t kMax = 8;
  std::size_t count = 0;
  for (const auto partition : request.partitions) {
    if (++count > kMax) break;
    text += fmt::format("{} \"{}\"", count == 1 ? " in partition" : ",", shortened(partition));
  }
  if (!request.data_tags.empty()) {
    text += fmt::format(" with {} data tag(s)", request.data_tags.size());
  }
  return text;
}

// Returns the hint for a refusal by a peer's permissions: nothing on this side can change it.
std::string hint_about_peer(const PermissionsHolder& holder, Code code,
                            const governance::RefusalAdvice& advice) {
  const std::string own(advice.hint.empty() ? info(code).hint : advice.hint);
  return fmt::format(
      "the permissions of {} decide this, not ours; if it should be allowed, change them where "
      "that "
      "participant runs: {}; then start it again",
      shortened(holder.peer_subject()), own);
}

// Returns the error for a refusal by a deny_rule or by the grant's default.
Error denied_error(Code code, const PermissionsHolder& holder, const CompiledGrant& grant,
                   const Decision& decision, std::string expected,
                   const governance::RefusalAdvice& advice = {}) {
  return Error(
      code, {.document = holder.document_name(),
             .line = decision.line(grant.grant()),
             .field = decision.rule ? "<deny_rule>" : "<default>",
             .expected = std::move(expected),
             .found = decision.rule ? "a deny_rule that matches first"
                                    : "no rule that matches, and the default DENY",
             .note = fmt::format(
                 "{}grant \"{}\" of {}{}{}", holder.remote() ? "the peer's own permissions, " : "",
                 shortened(grant.grant().name), shortened(grant.grant().subject_name),
                 advice.because.empty() ? "" : ": ", advice.because),
             .hint = holder.remote() ? hint_about_peer(holder, code, advice) : advice.hint});
}

// Does the same for an endpoint that was announced in a peer's name, possibly by an attacker.
Error announced_endpoint_error(const Error& refusal, Action action) {
  const Code code = action == Action::publish ? Code::announced_writer_not_allowed
                                              : Code::announced_reader_not_allowed;
  auto details = refusal.details();
  details.hint = fmt::format("{}; {}", details.hint, info(code).hint);
  return Error(code, std::move(details));
}

}  // namespace

Error topic_not_covered_error(const LocalParticipant& participant, std::string_view topic) {
  const auto documents = participant.judging_documents();
  return Error(Code::topic_not_covered,
               {.document = participant.governance_name,
                .line = documents->governance->domain_rule().line,
                .field = "<topic_access_rules>",
                .expected = fmt::format("a topic_rule for \"{}\"", shortened(topic)),
                .found = "none"});
}

Error endpoint_denied_error(const PermissionsHolder& holder, const CompiledGrant& grant,
                            const Decision& decision, Action action,
                            const spi::EndpointRequest& request) {
  const Code code =
      action == Action::publish ? Code::publish_not_allowed : Code::subscribe_not_allowed;
  std::vector<governance::DataTag> tags;
  for (const auto& tag : request.data_tags) tags.push_back({tag.name, tag.value});
  const governance::Request asked{request.topic_name, request.partitions, tags};
  // Names are compared only in local permissions: with a peer's own permissions, the peer could
  // make that as expensive as it likes.
  auto advice = holder.remote() ? advice_on_endpoint(grant, action, asked, decision)
                                : advice_on(grant, action, asked, decision);
  if (advice.hint.empty()) advice.hint = governance::hint_for_ros_topic(request.topic_name);
  const auto refusal = denied_error(
      code, holder, grant, decision,
      fmt::format("an allow_rule to {} {}", to_string(action), shown(request)), advice);
  return holder.remote() ? announced_endpoint_error(refusal, action) : refusal;
}

Error match_denied_error(const Error& why, Action action, const spi::AccessControl::Match& match) {
  auto details = why.details();
  // The hint of match_not_permitted counts, because the announcement may be forged.
  details.hint.clear();
  if (details.expected.empty())
    details.expected = fmt::format("permissions to {} {}", to_string(action), shown(match.local));
  if (details.found.empty()) details.found = info(why.code()).summary;
  if (match.remote_hides)
    details.note += std::string(details.note.empty() ? "" : "; ") +
                    "it has announced an endpoint without its endpoint_security_info, so all of "
                    "them are judged in the partitions of ours";
  return Error(Code::match_not_permitted, std::move(details));
}

Error topic_denied_error(const PermissionsHolder& holder, const CompiledGrant& grant,
                         const Decision& decision, std::string_view topic) {
  governance::RefusalAdvice advice;
  if (!holder.remote() && decision.rule == nullptr) {
    advice = advice_on_name(grant, Action::publish, topic);
    if (advice.hint.empty()) advice = advice_on_name(grant, Action::subscribe, topic);
  }
  if (advice.hint.empty()) advice.hint = governance::hint_for_ros_topic(topic);
  return denied_error(Code::topic_not_allowed, holder, grant, decision,
                      fmt::format("an allow_rule for topic \"{}\"", shortened(topic)), advice);
}

Error participant_denied_error(const PermissionsHolder& holder, const CompiledGrant& grant,
                               const Decision& decision) {
  return denied_error(Code::participant_not_allowed, holder, grant, decision,
                      "an allow_rule as the first rule for " +
                          governance::describe_domain(holder.participant()->domain,
                                                      holder.participant()->domain_tag));
}

}  // namespace ddssec::access_control
