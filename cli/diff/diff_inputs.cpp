#include "cli/diff/diff_inputs.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/documents/documents.hpp"
#include "cli/folders/ca_paths.hpp"
#include "cli/inputs/files.hpp"
#include "pki/certificate_source.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kWidth = 100;
constexpr std::size_t kMaxShownLength = 48;
constexpr std::size_t kMaxShown = 3;
constexpr std::size_t kMaxDomainsShown = 5;

std::string claimed_signer(const pki::DocumentForm& form) {
  const auto subject = form.embedded.empty() ? std::string() : form.embedded.front() + ", ";
  return subject + pki::signer_words(form);
}

Result<DiffSide> read_side(const fs::path& path, const Arguments& arguments, WallTime now) {
  DiffSide side{.path = path};
  DDSSEC_ASSIGN_OR_RETURN(auto octets, read_file(path, pki::kMaxDocumentOctets));
  side.octets = octets.size();
  auto form = pki::examine_document(octets);
  side.is_signed = form.wrapping != pki::DocumentWrapping::none &&
                   form.wrapping != pki::DocumentWrapping::unknown;
  if (!side.is_signed) {
    side.text = std::move(octets);
  } else if (arguments.has("--ca")) {
    const auto ca = ca_certificate_path(arguments.text("--ca"), "permissions");
    DDSSEC_ASSIGN_OR_RETURN(const auto proof, verified(path, ca, now));
    side.is_verified = true;
    side.signer = to_hex(proof.signer().fingerprint());
    side.text = to_bytes(proof.content());
    side.first_line = proof.first_line();
    side.signing_time = proof.signing_time();
  } else if (form.ambiguous) {
    return std::unexpected(form.ambiguous->with_default_document(path));
  } else {
    side.signer = claimed_signer(form);
    side.text = std::move(form.unverified_text);
    side.first_line = form.first_line;
    side.signing_time = form.signing_time;
  }
  return side;
}

std::string_view trust(const DiffSide& side) {
  return !side.is_signed ? "is not signed" : side.is_verified ? "verified" : "NOT verified";
}

}  // namespace

Result<DiffSides> diff_sides(fs::path (*document)(const fs::path&), const Arguments& arguments,
                             const Context& context) {
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(auto before, read_side(document(arguments.text("OLD")), arguments, now));
  DDSSEC_ASSIGN_OR_RETURN(auto after, read_side(document(arguments.text("NEW")), arguments, now));
  return DiffSides{std::move(before), std::move(after)};
}

ShownSigners ShownSigners::of(const DiffSides& sides) {
  return {if_any(sides.before.signer),
          if_any(sides.after.signer),
          sides.before.signer == sides.after.signer,
          {sides.before.is_verified, sides.after.is_verified}};
}

std::string signer_text(const DiffSides& sides) {
  if (!sides.before.is_signed && !sides.after.is_signed) return {};
  std::string text;
  if (sides.before.signer == sides.after.signer) {
    text = fmt::format("signer unchanged ({})\n", name_text(sides.after.signer));
  } else {
    const auto name = [](const DiffSide& side) {
      return side.signer.empty() ? std::string("no signer") : name_text(side.signer);
    };
    text = fmt::format("signer CHANGED\n  old: {}\n  new: {}\n", name(sides.before),
                       name(sides.after));
  }
  if (sides.before.is_verified && sides.after.is_verified) return text;
  return text + fmt::format("signatures: old {}, new {}{}\n", trust(sides.before),
                            trust(sides.after),
                            sides.before.is_verified || sides.after.is_verified
                                ? ""
                                : " (--ca CERT verifies them)");
}

Result<std::optional<std::string>> fail_on(const Arguments& arguments,
                                           const std::vector<std::string>& words) {
  if (!arguments.has("--fail-on")) return std::nullopt;
  const auto word = arguments.text("--fail-on");
  if (std::ranges::find(words, word) != words.end()) return word;
  return fail(Code::usage, {.field = "--fail-on",
                            .expected = fmt::format("{}", fmt::join(words, ", ")),
                            .found = '"' + word + '"'});
}

std::string escaped(std::string_view name) {
  std::string text;
  for (const char c : name) {
    const auto octet = static_cast<unsigned char>(c);
    text += octet < 0x20 || octet == 0x7F ? fmt::format("\\x{:02x}", octet) : std::string(1, c);
  }
  return text;
}

std::string name_text(std::string_view name) {
  if (name.empty()) return "(empty name)";
  auto text = escaped(name);
  if (text.size() <= kMaxShownLength) return text;
  // Cuts no letter of several octets in two.
  std::size_t end = kMaxShownLength - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + "...";
}

std::string names_text(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxShown, names.size()); ++i) {
    text += (i == 0 ? "" : ", ") + name_text(names[i]);
  }
  if (names.size() > kMaxShown) text += fmt::format(" and {} more", names.size() - kMaxShown);
  return text;
}

std::string domains_text(const std::vector<governance::DomainRange>& domains) {
  std::string text;
  for (std::size_t i = 0; i < std::min(kMaxDomainsShown, domains.size()); ++i) {
    const auto first = domains[i].first, last = domains[i].last;
    if (i > 0) text += ", ";
    text += first == last ? std::to_string(first) : fmt::format("{}-{}", first, last);
  }
  if (domains.size() > kMaxDomainsShown) {
    text += fmt::format(" and {} more", domains.size() - kMaxDomainsShown);
  }
  const bool one = domains.size() == 1 && domains[0].first == domains[0].last;
  return (one ? "domain " : "domains ") + text;
}

std::string lines_text(int old_line, int new_line) {
  std::string text;
  if (old_line > 0) text += fmt::format("old:{}", old_line);
  if (new_line > 0) text += fmt::format("{}new:{}", text.empty() ? "" : " ", new_line);
  return text;
}

Json domains_json(const std::vector<governance::DomainRange>& domains) {
  Json list = Json::array();
  for (const auto& range : domains) list.push_back({range.first, range.last});
  return list;
}

std::string interpretations_text(const governance::Interpretations& interpretations) {
  if (interpretations.all.empty()) return {};
  std::string text = "what other products may read differently, and only one document has:\n";
  for (const auto& reading : interpretations.all)
    text += wrapped("  interop   ",
                    {escaped(reading.sentence),
                     reading.is_new ? lines_text(0, reading.line) : lines_text(reading.line, 0)});
  return interpretations.is_complete ? text : text + "  there may be more\n";
}

ShownInterpretations ShownInterpretations::of(const governance::Interpretations& interpretations,
                                              const DiffSides& sides) {
  ShownInterpretations out{.complete = interpretations.is_complete};
  for (const auto& reading : interpretations.all)
    out.all.push_back({reading.is_new ? "new" : "old", if_any(reading.expression), reading.sentence,
                       reading.widens,
                       place(reading.is_new ? sides.after.path : sides.before.path, reading.line)});
  return out;
}

std::optional<std::string> if_any(std::string_view text) {
  return text.empty() ? std::nullopt : std::optional(std::string(text));
}

std::optional<std::string> place(const fs::path& path, int line) {
  return line > 0 ? std::optional(fmt::format("{}:{}", path.string(), line)) : std::nullopt;
}

std::string wrapped(std::string_view heading, const std::vector<std::string>& parts) {
  std::string text, line(heading);
  const std::string indentation(heading.size(), ' ');
  const auto put = [&](std::string_view piece, std::string_view gap) {
    const bool first = line.size() == heading.size();
    if (!first && line.size() + gap.size() + piece.size() > kWidth) {
      text += line + "\n";
      line = indentation;
    } else if (!first) {
      line += gap;
    }
    line += piece;
  };
  for (const auto& part : parts) {
    if (part.empty()) continue;
    if (heading.size() + part.size() <= kWidth) {
      put(part, "  ");
      continue;
    }
    std::string_view rest = part;
    for (std::string_view gap = "  "; !rest.empty(); gap = " ") {
      const auto end = std::min(rest.find(' '), rest.size());
      put(rest.substr(0, end), gap);
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return text + line + "\n";
}

}  // namespace ddssec::cli
