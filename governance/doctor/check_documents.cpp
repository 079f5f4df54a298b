// Form, signature and signer of both documents, and whether they can be read.
#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "governance/doctor/checks.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr Outcomes kNobody = Outcomes::all(Outcome::fail);

/// What the checks need of either document.
struct Subject {
  std::string_view about;  ///< "governance", "permissions"
  fs::path path;
  const pki::DocumentForm& form;
  const Status& cyclonedds_belief;
  const Status& fastdds_belief;
  const Status& our_belief;
  const Status& parsed;
  const std::vector<Note>* notes;
};

template <class Model>
Subject subject(std::string_view about, const fs::path& path,
                const LoadedDocument<Model>& document) {
  return {about,
          path,
          document.form,
          document.cyclonedds_belief,
          document.fastdds_belief,
          document.our_belief,
          document.parsed,
          document.model ? &document.model->notes : nullptr};
}

Outcome of(bool believed, Outcome if_believed = Outcome::ok) {
  return believed ? if_believed : Outcome::fail;
}

// `accepted`: what it means if stock products believe the document.
Outcomes outcomes(const Subject& subject, Outcome accepted = Outcome::ok) {
  return {of(subject.cyclonedds_belief.has_value(), accepted),
          of(subject.fastdds_belief.has_value(), accepted), of(subject.our_belief.has_value())};
}

// What is odd about how the document is wrapped; "" if nothing.
std::string odd_form(const Subject& subject) {
  const auto& form = subject.form;
  const auto file = subject.path.filename().string();
  if (form.wrapping != pki::DocumentWrapping::multipart)
    return fmt::format("{} is {}{}; it must be multipart/signed with a text/plain header", file,
                       to_string(form.wrapping),
                       form.has_text_header ? " with a text/plain header" : "");
  if (!form.has_text_header)
    return fmt::format(
        "{} has no \"Content-Type: text/plain\" header inside its signed part, "
        "which every product asks for (openssl smime -sign -text, without -binary)",
        file);
  if (form.embedded.empty())
    return fmt::format(
        "{} does not hold its signer's certificate (-nocerts), which stock products "
        "look for there",
        file);
  return {};
}

std::string cas_of(const LoadedFolder& folder) {
  std::string out;
  for (const auto& ca : *folder.permissions_cas)
    if (out.size() < 512)
      out +=
          fmt::format("{}\"{}\" (serial {})", out.empty() ? "" : ", ", ca.subject(), ca.serial());
  return out;
}

std::string who_signed(const Subject& subject) {
  const auto& form = subject.form;
  const auto by =
      form.embedded.empty() ? std::string("somebody") : '"' + form.embedded.front() + '"';
  return fmt::format("{} was signed by {} (serial {}, issued by \"{}\")",
                     subject.path.filename().string(), by, form.signer_serial, form.signer_issuer);
}

void check_signer(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  const bool stock_believes =
      subject.cyclonedds_belief.has_value() || subject.fastdds_belief.has_value();
  const auto ca_file = folder.paths.permissions_ca.filename().string();
  const auto message =
      fmt::format("{}; {} holds {}{}", who_signed(subject), ca_file, cas_of(folder),
                  stock_believes ? ", below which the signer's certificate merely "
                                   "stands, and stock products believe it"
                                 : "");
  out.report(outcomes(subject, Outcome::unsafe),
             {.rule = stock_believes ? Rule::DOC033 : Rule::DOC032,
              .message = message,
              .document = subject.path},
             subject.about);
}

void report(Rule rule, const Subject& subject, const Error& error, Outcome accepted,
            Diagnosis& out) {
  out.report(outcomes(subject, accepted),
             {.rule = rule,
              .message = fmt::format("{}: {}", subject.path.filename().string(), error.message()),
              .document = subject.path},
             subject.about);
}

// Ours believes it, and a stock product does not: the CA file is at fault.
void report_ca_file(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  out.report(
      outcomes(subject),
      {.rule = Rule::DOC032,
       .message = fmt::format(
           "{}; Cyclone DDS 0.10.2 reads the first certificate of {} only, and both stock "
           "products need the path up to a self-signed CA; it holds {}",
           who_signed(subject), folder.paths.permissions_ca.filename().string(), cas_of(folder)),
       .document = subject.path},
      subject.about);
}

void check_belief(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  if (const auto odd = odd_form(subject); !odd.empty())
    return out.report(outcomes(subject),
                      {.rule = Rule::DOC030, .message = odd, .document = subject.path},
                      subject.about);
  out.pass(Rule::DOC030, subject.about);
  if (!folder.permissions_cas) return;
  if (outcomes(subject).all_ok()) return out.pass(Rule::DOC031, subject.about);
  if (subject.our_belief) return report_ca_file(folder, subject, out);
  const auto& error = subject.our_belief.error();
  switch (error.code()) {
    case Code::smime_signer_not_permissions_ca:
      return check_signer(folder, subject, out);
    case Code::smime_digest_too_weak:
      return report(Rule::DOC034, subject, error, Outcome::unsafe, out);
    case Code::key_usage_forbids:
      return report(Rule::DOC035, subject, error, Outcome::ok, out);
    case Code::certificate_expired:
    case Code::certificate_not_yet_valid:
      return;  // the CA's dates have been reported
    default:
      return report(Rule::DOC031, subject, error, Outcome::ok, out);
  }
}

// What the reader of a document noted, and whom it keeps out. Measured.
struct Spelling {
  std::string_view words;
  Outcomes outcomes;
};
constexpr std::array kSpellings{
    Spelling{"Fast DDS refuses it", {.fastdds = Outcome::fail}},
    Spelling{"has no <default>", {.fastdds = Outcome::fail}},
    Spelling{"has no <min>", {.cyclonedds = Outcome::fail}},
    Spelling{"came with DDS-Security 1.2", {.cyclonedds = Outcome::fail, .fastdds = Outcome::fail}},
    Spelling{"is not in capitals", {.cyclonedds = Outcome::fail, .fastdds = Outcome::fail}},
};

Outcomes outcomes_of(const Note& note) {
  const auto found = std::ranges::find_if(kSpellings, [&](const Spelling& spelling) {
    return note.text.find(spelling.words) != note.text.npos;
  });
  return found == kSpellings.end() ? Outcomes{} : found->outcomes;
}

void check_text(const Subject& subject, Diagnosis& out) {
  if (subject.form.unverified_text.empty()) return;  // its form has been reported
  if (!subject.parsed)
    return out.report(kNobody,
                      {.rule = Rule::DOC036,
                       .message = fmt::format("{}: {}{}", subject.path.filename().string(),
                                              subject.parsed.error().details().field.empty()
                                                  ? ""
                                                  : subject.parsed.error().details().field + ": ",
                                              subject.parsed.error().message()),
                       .document = subject.path,
                       .line = subject.parsed.error().details().line},
                      subject.about);
  out.pass(Rule::DOC036, subject.about);
  out.pass(Rule::DOC037, subject.about);
  for (const auto& note : *subject.notes) {
    if (note.text.starts_with("<not_") || note.text.find("names no zone") != note.text.npos)
      continue;  // has a rule of its own
    const auto who = outcomes_of(note);
    out.report(who,
               {.rule = Rule::DOC037,
                .message = note.text,
                .document = subject.path,
                .line = note.line,
                .severity = who.all_ok() ? Severity::warning : Severity::error},
               subject.about);
  }
}

void check_one(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  check_belief(folder, subject, out);
  check_text(subject, out);
}

}  // namespace

void check_documents(const LoadedFolder& folder, const Settings&, Diagnosis& out) {
  if (folder.governance.readable)
    check_one(folder, subject("governance", folder.paths.governance, folder.governance), out);
  if (folder.permissions.readable)
    check_one(folder, subject("permissions", folder.paths.permissions, folder.permissions), out);
}

}  // namespace ddssec::governance::doctor
