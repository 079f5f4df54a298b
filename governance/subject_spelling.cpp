#include "governance/subject_spelling.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "governance/cyclonedds_subject.hpp"
#include "governance/fastdds_subject.hpp"
#include "governance/lint_findings.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

bool seems_root_first(const pki::SubjectName& name) {
  constexpr std::string_view kRoots[] = {"C", "O", "DC"};
  const auto& all = name.attributes();
  return all.size() > 1 && all.back().type == "CN" &&
         std::ranges::find(kRoots, all.front().type) != std::end(kRoots);
}

bool is_beyond_ascii(char c) { return static_cast<unsigned char>(c) >= 0x80; }

bool has_letters_beyond_ascii(const pki::SubjectName& name) {
  return std::ranges::any_of(name.attributes(), [](const pki::NameAttribute& attribute) {
    return std::ranges::any_of(attribute.value, is_beyond_ascii);
  });
}

// False if the text of a certificate has escapes or numbers that rfc2253() does not write.
bool is_written_alike(const pki::SubjectName& name) {
  return std::ranges::all_of(name.attributes(), [](const pki::NameAttribute& attribute) {
    const bool is_number = attribute.type.find_first_not_of("0123456789.") == std::string::npos;
    return !is_number && std::ranges::none_of(attribute.value, [](char c) {
      return static_cast<unsigned char>(c) < ' ' || c == '\x7f';
    });
  });
}

// Escapes letters beyond ASCII as Certificate::subject does.
std::string with_escapes(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += is_beyond_ascii(c) ? fmt::format("\\{:02X}", static_cast<unsigned char>(c))
                              : std::string(1, c);
  return out;
}

std::string text_in_certificate(const pki::SubjectName& name) {
  return rfc2253(name, name.is_root_first() || seems_root_first(name));
}

std::string why_not_recognised(const Grant& grant, const pki::SubjectName& name) {
  const auto& text = grant.subject_name;
  if (name.is_root_first())
    return in_quotes(text) + " is in the form with slashes, which Fast DDS does not read";
  if (seems_root_first(name))
    return in_quotes(text) +
           " begins with the country or organisation: Fast DDS does not recognise a certificate "
           "by it";
  const auto plain = rfc2253(name, false);
  if (text == plain) return between_line_breaks(text);
  if (text.size() > plain.size() && text.find(' ') != text.npos)
    return in_quotes(text) + " has blanks beside ',' or '=', and Cyclone DDS keeps them";
  return fmt::format("{} is {} in a certificate, and stock products compare the texts",
                     in_quotes(text), in_quotes(plain));
}

}  // namespace

std::vector<std::string> not_recognising(const Grant& grant, std::string_view subject,
                                         std::string_view in_utf8) {
  std::vector<std::string> out;
  if (!cyclonedds_applies_grant(grant.subject_name, subject)) out.emplace_back(kCyclone);
  if (grant.subject_has_line_breaks || !fastdds_takes(grant.subject_name, in_utf8))
    out.emplace_back(kFastDds);
  return out;
}

std::string between_line_breaks(const std::string& subject) {
  return in_quotes(subject) + " is between line breaks or tabs, which Fast DDS reads as part of it";
}

std::optional<SpellingProblem> misspelt(const Grant& grant) {
  if (grant.subject_is_expression) return std::nullopt;
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (!name) return SpellingProblem{in_quotes(grant.subject_name) + " is no subject name"};
  if (!is_written_alike(*name) || has_letters_beyond_ascii(*name)) return std::nullopt;
  const auto right = text_in_certificate(*name);
  auto products = not_recognising(grant, right, right);
  if (products.empty()) return std::nullopt;
  return SpellingProblem{why_not_recognised(grant, *name), right, std::move(products)};
}

// Cyclone DDS compares letters beyond ASCII as RFC 2253 escapes them, Fast DDS as they are
// (measured).
std::optional<SpellingProblem> letters_beyond_ascii(const Grant& grant) {
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (grant.subject_is_expression || !name || !has_letters_beyond_ascii(*name)) return std::nullopt;
  const bool is_escaped = std::ranges::none_of(grant.subject_name, is_beyond_ascii);
  const auto text = text_in_certificate(*name);
  auto products = not_recognising(grant, with_escapes(text), text);
  if (products.empty()) return std::nullopt;
  auto message =
      fmt::format("the subject name {} has letters beyond ASCII, {}: {} the certificate by it",
                  in_quotes(grant.subject_name), is_escaped ? "escaped" : "not escaped",
                  products.size() > 1            ? "Cyclone DDS and Fast DDS do not recognise"
                  : products.front() == kCyclone ? "Cyclone DDS does not recognise"
                                                 : "Fast DDS does not recognise");
  return SpellingProblem{std::move(message), {}, std::move(products)};
}

}  // namespace ddssec::governance
