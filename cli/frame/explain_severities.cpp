#include "cli/frame/explain_severities.hpp"

#include <algorithm>

namespace ddssec::cli {
namespace {

constexpr auto note = Severity::informational;
using enum Severity;

constexpr OtherSeverity kOthers[] = {
    {"DOC004", error, "in a keystore, or in public/ of one"},
    {"DOC010", warning,
     "where permissions sign puts the document into a participant's folder, or the subject may be "
     "mistyped"},
    {"DOC011", warning, "where the other product would take the grant"},
    {"DOC023", warning, "where the list is missing or the CA has a newer one"},
    {"DOC024", warning, "where the successor of its CA revoked it"},
    {"DOC112", warning, "where the participant starts without it"},
    {"DOC115", note, "where a part of the entries has no effect"},
    {"DOC037 DOC055", error, "where a product refuses the document, or a denial does not hold"},
    {"DOC042", error, "where Fast DDS and the others disagree now"},
    {"DOC043", error, "where Cyclone DDS takes the grant of another subject"},
    {"DOC050", warning, "for an enclave that is being made"},
    {"DOC053", warning, "where can answers for ddssec and Cyclone DDS refuses the topic"},
    {"DOC062", warning, "where ROS_SECURITY_KEYSTORE is a relative path"},
    {"DOC068", warning, "where the application may run without ROS 2"},
    {"DOC083", note, "where --vendor does not name the products"},
    {"DOC086", warning, "where not every topic was looked at"},
    {"DOC091", warning, "where the keys can still be used"},
    {"DOC094", error, "where --vendor names two versions that do not find each other"},
    {"DOC101", warning, "where the environment names no configuration, or one for another purpose"},
    {"DOC093 DOC103", warning, "where the embedded participant may be meant"},
    {"DOC104", warning, "for a group that can write, or another owner"},
    {"DOC107", warning, "for products that --vendor of check does not name"},
    {"GOV010", warning, "where the rules before it protect alike"},
    {"GOV040", note, "for some topics of a domain that protects others"},
    {"GOV012 PERM013", note, "where Cyclone DDS and Fast DDS agree"},
    {"PERM002", error, "where the grant is over or never valid"},
    {"PERM002", note, "for a fraction of a second"},
    {"PERM010", warning, "for a grant that follows the other in time"},
    {"PERM011", error, "where the name is not the certificate's"},
    {"PERM012", error, "where the rule denies"},
    {"PERM012", note, "where the rule repeats others"},
    {"PERM014", note, "for relay elements"},
    {"PERM034", warning, "for a topic of an enclave that no ROS 2 node uses"},
    {"PERM040", error, "for the participant's own grant, in doctor --ros and keystore verify"},
};

}  // namespace

std::span<const OtherSeverity> other_severities() { return kOthers; }

Severity severity_in_tool(Code code) {
  const bool is_of_input = Code::truncated <= code && code <= Code::ocsp_not_yet_valid;
  return is_of_input ? std::max(info(code).severity, error) : info(code).severity;
}

}  // namespace ddssec::cli
