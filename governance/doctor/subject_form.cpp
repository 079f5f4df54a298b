#include "governance/doctor/subject_form.hpp"

#include <algorithm>
#include <vector>

#include "base/text.hpp"
#include "governance/cyclonedds_subject.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/fastdds_subject.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanksOfNames = " \t\r\n";

bool has_same_attributes(std::string_view text, const pki::Certificate& certificate) {
  const auto sorted = [](std::vector<pki::NameAttribute> attributes) {
    std::ranges::sort(attributes);
    return attributes;
  };
  const auto name = pki::SubjectName::parse(text);
  return name &&
         sorted(name->attributes()) == sorted(pki::SubjectName::of(certificate).attributes());
}

// Unsafe if a grant for another subject than the certificate's is applied.
Outcome cyclonedds_outcome(std::string_view text, const pki::Certificate& certificate) {
  if (!cyclonedds_applies_grant(text, certificate.subject())) return Outcome::fail;
  return has_same_attributes(text, certificate) ? Outcome::ok : Outcome::unsafe;
}

// Commas and blanks at the end have no meaning, so they are removed before the comparison.
Outcome fastdds_outcome(std::string_view text, const pki::Certificate& certificate,
                        bool any_order) {
  const auto reads = any_order ? fastdds3_applies_grant : fastdds_takes;
  if (!reads(text, pki::subject_in_utf8(certificate))) return Outcome::fail;
  const auto end = text.find_last_not_of(", \t\r\n");
  return has_same_attributes(text.substr(0, end == text.npos ? 0 : end + 1), certificate)
             ? Outcome::ok
             : Outcome::unsafe;
}

Outcome outcome(bool reads) { return reads ? Outcome::ok : Outcome::fail; }

}  // namespace

Outcomes reads_subject(std::string_view text, const pki::Certificate& certificate,
                       const Lineup& lineup) {
  const bool any_order = measured(Variant::subject_mixed_order, lineup).fastdds == Outcome::ok;
  const auto name = pki::SubjectName::parse(text);
  const auto subject = trimmed(text, kBlanksOfNames);
  return {.cyclonedds = cyclonedds_outcome(subject, certificate),
          .fastdds = fastdds_outcome(text, certificate, any_order),
          .ddssec = outcome(name && name->matches(certificate))};
}

}  // namespace ddssec::governance::doctor
