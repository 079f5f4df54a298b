#include "cli/diff/permissions_forecast.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/diff/forecast.hpp"
#include "governance/compare/subjects.hpp"
#include "governance/grant.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

using governance::ChangeClass;
using governance::Grant;
using governance::Grants;

// The outcomes in the order of severity.
enum class PermissionsOutcome : std::uint8_t {
  same,
  live,
  live_later,               // the grant begins in the future
  live_if_signer_accepted,  // another CA signed it
  restart,                  // the participant is cut off already
  refused,
};

constexpr OutcomeWords<PermissionsOutcome> kPermissionsWords[] = {
    {PermissionsOutcome::same, "same", "nothing changes"},
    {PermissionsOutcome::live, "live", "taken while they run"},
    {PermissionsOutcome::live_later, "live when it begins", "taken while they run, when it begins"},
    {PermissionsOutcome::live_if_signer_accepted, "live if the signer is believed",
     "refused, unless the new signer is one of their permissions CAs"},
    {PermissionsOutcome::restart, "restart", "restart"},
    {PermissionsOutcome::refused, "refused",
     "refused: the old document stays in force until a restart or its end"}};

std::string_view live_word(PermissionsOutcome live) {
  return words_of(kPermissionsWords, live).word;
}
std::string outcome_text(PermissionsOutcome live) {
  return std::string(words_of(kPermissionsWords, live).text);
}

using Prediction = Forecast<PermissionsOutcome>;

const Grant* begins_after(const Grants& grants, WallTime now) {
  const auto found = std::ranges::find_if(
      grants, [&](const Grant* one) { return one->validity.not_before > now; });
  return found == grants.end() ? nullptr : *found;
}

// Predicts what find_grant and check_follows decide for a participant of this subject.
void add_subject(const governance::Subject& subject, WallTime now, Prediction& out) {
  const auto* const in_force = governance::valid_at(subject.old_grants, now);
  if (subject.old_grants.empty()) return;
  const auto& name = governance::spelling_of(subject).subject_name;
  if (in_force == nullptr) {
    const auto& old = *subject.old_grants.front();
    if (old.validity.not_after <= now)
      out.add(PermissionsOutcome::restart,
              fmt::format("{}: the old grant ended at {}, and so did such a participant", name,
                          to_string(old.validity.not_after)),
              0);
    return;
  }
  if (subject.new_grants.empty())
    return out.add(PermissionsOutcome::refused,
                   fmt::format("there is no grant for {} any more", name), 0);
  const auto* const next = governance::valid_at(subject.new_grants, now);
  if (next == nullptr) {
    if (const auto* const later = begins_after(subject.new_grants, now))
      return out.add(PermissionsOutcome::live_later,
                     fmt::format("{}: from {}", name, to_string(later->validity.not_before)),
                     later->line);
    const auto& ended = *subject.new_grants.front();
    return out.add(
        PermissionsOutcome::refused,
        fmt::format("{}: the new grant ended at {}", name, to_string(ended.validity.not_after)),
        ended.line);
  }
  if (next->validity.not_before < in_force->validity.not_before)
    return out.add(
        PermissionsOutcome::refused,
        fmt::format("as older: {}: not_before {} must be {} or later", name,
                    to_string(next->validity.not_before), to_string(in_force->validity.not_before)),
        next->line);
  out.add(PermissionsOutcome::live, "", 0);
}

// True if check_follows refuses the document because of its signing time.
bool is_signed_earlier(const DiffSides& sides) {
  const auto &since = sides.before.signing_time, &time = sides.after.signing_time;
  return sides.after.is_signed && since && (!time || *time < *since);
}

Prediction forecast(const PermissionsChangeOver& change, const DiffSides& sides) {
  Prediction out;
  if (sides.after.octets > pki::kMaxSentPermissionsOctets)
    out.add(PermissionsOutcome::refused,
            fmt::format("it has {} octets, and may have {}", sides.after.octets,
                        pki::kMaxSentPermissionsOctets),
            0);
  for (const auto& subject : governance::subjects_of(change.before, change.after).all)
    add_subject(subject, change.now, out);
  if (is_signed_earlier(sides)) {
    const auto& time = sides.after.signing_time;
    out.add(PermissionsOutcome::refused,
            fmt::format("as older: the signing time {} must be {} or later",
                        time ? to_string(*time) : "(none)", to_string(*sides.before.signing_time)),
            0);
  }
  const auto &before = sides.before.signer, &after = sides.after.signer;
  if (!before.empty() && !after.empty() && before != after)
    out.add(PermissionsOutcome::live_if_signer_accepted, "another CA signed the new document", 0);
  return out;
}

bool takes_away(const governance::PermissionsDiff& diff) {
  return diff.verdict == ChangeClass::narrower || diff.verdict == ChangeClass::mixed ||
         diff.verdict == ChangeClass::unknown;
}

// True for a change of an endpoint's rights, whatever the time is, if both documents have the
// subject.
bool is_about_rights(const governance::PermissionChange& change,
                     const governance::PermissionsDiff& diff) {
  if (change.element != "rule" && change.element != "default" && change.element != "join")
    return false;
  return std::ranges::none_of(diff.changes, [&](const auto& other) {
    return other.element == "grant" && other.subject == change.subject;
  });
}

template <class... Classes>
bool changes_rights(const governance::PermissionsDiff& diff, Classes... classes) {
  return !diff.is_exact || std::ranges::any_of(diff.changes, [&](const auto& change) {
    return is_about_rights(change, diff) && ((change.change == classes) || ...);
  });
}

// The core of Cyclone DDS does not judge again what it has matched, and peers there learn of
// permissions only in a handshake. If an endpoint loses or gains a right, its sessions with peers
// on our plugins end.
std::string_view word_in_cyclonedds(PermissionsOutcome live,
                                    const governance::PermissionsDiff& diff) {
  using enum ChangeClass;
  if (live != PermissionsOutcome::live || !changes_rights(diff, narrower, mixed, unknown, wider))
    return live_word(live);
  return "live, sessions begin again";
}

}  // namespace

PermissionsForecast forecast_of(const PermissionsChangeOver& change, const DiffSides& sides) {
  const bool is_same = sides.before.text == sides.after.text &&
                       sides.before.signer == sides.after.signer && !is_signed_earlier(sides);
  const auto ours = is_same ? Prediction() : forecast(change, sides);
  const auto stock = is_same ? PermissionsOutcome::same : PermissionsOutcome::restart;
  PermissionsForecast out{.embedded = live_word(ours.outcome),
                          .cyclonedds_ddssec = word_in_cyclonedds(ours.outcome, change.diff),
                          .cyclonedds = live_word(stock),
                          .fastdds = live_word(stock),
                          .reason = ours.reason,
                          .at = place(sides.after.path, ours.line)};
  const bool narrows = takes_away(change.diff);
  constexpr std::string_view kHeading = "running participants: ";
  const std::string indentation(kHeading.size(), ' ');
  out.text += wrapped(
      kHeading, {"on ddssec's plugins:", outcome_text(ours.outcome),
                 ours.reason.empty() ? std::string() : fmt::format("({})", escaped(ours.reason))});
  const bool is_taken = ours.outcome >= PermissionsOutcome::live &&
                        ours.outcome <= PermissionsOutcome::live_if_signer_accepted;
  if (is_taken && narrows)
    out.text += wrapped(indentation,
                        {"what was taken away ends within a second between embedded participants;",
                         "in Cyclone DDS within two seconds: if an endpoint loses a right, the",
                         "sessions with peers on ddssec's plugins end and begin again"});
  if (is_taken && changes_rights(change.diff, ChangeClass::mixed, ChangeClass::wider))
    out.text +=
        wrapped(indentation, {"rights that are new count at once between embedded participants;",
                              "in Cyclone DDS within two seconds: if an endpoint needs one, the",
                              "sessions with peers on ddssec's plugins end once and begin again"});
  out.text += wrapped(indentation,
                      {"on those of Cyclone DDS and Fast DDS:", outcome_text(stock),
                       !is_same && narrows ? "until then what was taken away stays allowed" : ""});
  return out;
}

}  // namespace ddssec::cli
