#include "governance/doctor/subject_form.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "governance/doctor/measured.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kBlanksOfNames = " \t\r\n";

// The parts between separators that no backslash stands before.
std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts(1);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escaped = i > 0 && text[i - 1] == '\\';
    if (text[i] == separator && !escaped)
      parts.emplace_back();
    else
      parts.back().push_back(text[i]);
  }
  return parts;
}

std::string_view type_of(std::string_view piece) { return piece.substr(0, piece.find('=')); }

bool has_same_attributes(std::string_view text, const pki::Certificate& certificate) {
  const auto sorted = [](std::vector<pki::NameAttribute> attributes) {
    std::ranges::sort(attributes);
    return attributes;
  };
  const auto name = pki::SubjectName::parse(text);
  return name &&
         sorted(name->attributes()) == sorted(pki::SubjectName::of(certificate).attributes());
}

// A grant that says something else than the certificate is taken, and ought not to be.
Outcome cyclonedds_outcome(std::string_view text, const pki::Certificate& certificate) {
  if (!cyclonedds_takes(text, certificate.subject())) return Outcome::fail;
  return has_same_attributes(text, certificate) ? Outcome::ok : Outcome::unsafe;
}

bool fastdds_reads(std::string_view text, const std::string& subject) {
  std::string joined;
  for (auto part : split(text, ',')) {
    if (!joined.empty()) joined += ',';
    joined += trimmed(part, kBlanksOfNames);
  }
  return joined == subject;
}

// Since some version the order of the parts and blanks around '=' do not matter.
bool newer_fastdds_reads(std::string_view text, const std::string& subject) {
  const auto parts_of = [](std::string_view name) {
    std::vector<std::string> out;
    for (const auto& part : split(name, ',')) {
      const auto equals = std::min(part.find('='), part.size());
      out.push_back(
          std::string(trimmed(std::string_view(part).substr(0, equals))) + '=' +
          std::string(trimmed(std::string_view(part).substr(std::min(equals + 1, part.size())))));
    }
    std::ranges::sort(out);
    return out;
  };
  return parts_of(text) == parts_of(subject);
}

Outcome outcome(bool reads) { return reads ? Outcome::ok : Outcome::fail; }

}  // namespace

// As strtok does: no escapes, and nothing between two separators.
std::vector<std::string_view> pieces_for_cyclonedds(std::string_view text) {
  constexpr std::string_view kSeparators = ",/|";
  std::vector<std::string_view> out;
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of(kSeparators), text.size());
    if (end > 0) out.push_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return out;
}

// Of several pieces of one type the first counts.
bool cyclonedds_takes(std::string_view grant, std::string_view certificate) {
  const auto said = pieces_for_cyclonedds(grant);
  return std::ranges::all_of(pieces_for_cyclonedds(certificate), [&](std::string_view piece) {
    const auto found = std::ranges::find(said, type_of(piece), type_of);
    return found != said.end() && *found == piece;
  });
}

Outcomes reads_subject(std::string_view text, const pki::Certificate& certificate,
                       const Lineup& lineup) {
  const bool any_order = measured(Variant::subject_mixed_order, lineup).fastdds == Outcome::ok;
  const auto fastdds = any_order ? newer_fastdds_reads : fastdds_reads;
  const auto name = pki::SubjectName::parse(text);
  const auto subject = trimmed(text, kBlanksOfNames);
  return {.cyclonedds = cyclonedds_outcome(subject, certificate),
          .fastdds = outcome(fastdds(subject, certificate.subject())),
          .ours = outcome(name && name->matches(certificate))};
}

}  // namespace ddssec::governance::doctor
