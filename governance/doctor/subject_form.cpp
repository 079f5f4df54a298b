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

bool cyclonedds_reads(std::string_view text, const std::string& subject) {
  const bool slashes = text.starts_with('/');
  auto said = split(slashes ? text.substr(1) : text, slashes ? '/' : ',');
  auto meant = split(subject, ',');
  std::ranges::sort(said);
  std::ranges::sort(meant);
  return said == meant;
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

Outcomes reads_subject(std::string_view text, const pki::Certificate& certificate,
                       const Lineup& lineup) {
  const bool any_order = measured(Variant::subject_mixed_order, lineup).fastdds == Outcome::ok;
  const auto fastdds = any_order ? newer_fastdds_reads : fastdds_reads;
  const auto name = pki::SubjectName::parse(text);
  const auto subject = trimmed(text, kBlanksOfNames);
  return {.cyclonedds = outcome(cyclonedds_reads(subject, certificate.subject())),
          .fastdds = outcome(fastdds(subject, certificate.subject())),
          .ours = outcome(name && name->matches(certificate))};
}

}  // namespace ddssec::governance::doctor
