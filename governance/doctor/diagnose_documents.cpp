// Form, signature and signer of both documents, and whether they can be read.
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "base/shell_word.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/stock_spelling.hpp"
#include "governance/lint.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

// The data that the checks need about each document.
struct Subject {
  std::string_view about;  // "governance", "permissions"
  fs::path path;
  const pki::DocumentForm& form;
  const Status& cyclonedds_verdict;
  const Status& fastdds_verdict;
  const Status& our_verdict;
  const Status& parsed;
  const Error* unread;  // the reason why there is no model; nullptr if there is one
  const std::vector<Note>* notes;
  const std::vector<Variant>& left_out;
  bool has_joined_values;
  bool is_refused_by_fastdds;
  const Lineup& lineup;
};

template <class Model>
Subject subject(std::string_view about, const fs::path& path, const LoadedDocument<Model>& document,
                const Lineup& lineup) {
  return {about,
          path,
          document.form,
          document.cyclonedds_verdict,
          document.fastdds_verdict,
          document.our_verdict,
          document.parsed,
          document.model ? nullptr : &document.unread(),
          document.model ? &document.model->notes : nullptr,
          document.left_out,
          document.has_joined_values,
          document.is_refused_by_fastdds,
          lineup};
}

Outcome of(bool is_accepted, Outcome if_accepted = Outcome::ok) {
  return is_accepted ? if_accepted : Outcome::fail;
}

// `accepted` is the outcome if a stock product accepts the document.
Outcomes outcomes(const Subject& subject, const Outcomes& accepted = {}) {
  return {of(subject.cyclonedds_verdict.has_value(), accepted.cyclonedds),
          of(subject.fastdds_verdict.has_value(), accepted.fastdds),
          of(subject.our_verdict.has_value())};
}

// The outcomes of stock products, as measured with the variant.
Outcomes refused_by_ours(Variant variant, const Subject& subject) {
  auto out = measured(variant, subject.lineup);
  out.ddssec = Outcome::fail;
  return out;
}

// If the signer's certificate is not inside, OpenSSL finds no signer, but a product may find one in
// another way. If there are several texts, the version of OpenSSL decides which one a product
// reads. Stock products start with the text that this OpenSSL believes (measured).
Outcomes outcomes_of_form(const Subject& subject) {
  const auto& form = subject.form;
  if (form.ambiguous)
    return {of(subject.cyclonedds_verdict.has_value(), Outcome::unsafe),
            of(subject.fastdds_verdict.has_value(), Outcome::unsafe), Outcome::fail};
  const bool lacks_signer = form.wrapping == pki::DocumentWrapping::multipart &&
                            form.has_text_header && form.embedded.empty();
  return lacks_signer && subject.our_verdict ? measured(Variant::form_nocerts, subject.lineup)
                                             : outcomes(subject);
}

// Describes a peculiarity in the form of the document; "" if there is none.
std::string odd_form(const Subject& subject) {
  const auto& form = subject.form;
  const auto file = subject.path.filename().string();
  if (form.wrapping != pki::DocumentWrapping::multipart)
    return fmt::format("{} is {}{}; it must be multipart/signed with a text/plain header", file,
                       to_string(form.wrapping),
                       form.has_text_header ? " with a text/plain header" : "");
  if (form.ambiguous)
    return fmt::format("{} can be read in several ways: {}", file, form.ambiguous->message());
  if (!form.has_text_header)
    return fmt::format(
        "{} has no \"Content-Type: text/plain\" header inside its signed part, "
        "which every product asks for (openssl smime -sign -text, without -binary)",
        file);
  if (form.embedded.empty())
    return fmt::format(
        "{} does not hold its signer's certificate (-nocerts), which most stock products "
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
  const auto by = form.embedded.empty() ? std::string("another certificate")
                                        : '"' + form.embedded.front() + '"';
  const auto which =
      form.signer_key_id.empty()
          ? fmt::format("serial {}, issued by \"{}\"", form.signer_serial, form.signer_issuer)
          : pki::signer_words(form);
  return fmt::format("{} was signed by {} ({})", subject.path.filename().string(), by, which);
}

void diagnose_signer(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  const auto out_of_it =
      outcomes(subject, measured(Variant::permissions_by_itself, subject.lineup));
  const bool is_accepted_by_stock =
      out_of_it.cyclonedds != Outcome::fail || out_of_it.fastdds != Outcome::fail;
  const auto ca_file = folder.paths.permissions_ca.filename().string();
  const auto message =
      fmt::format("{}; {} holds {}{}", who_signed(subject), ca_file, cas_of(folder),
                  is_accepted_by_stock ? ", below which the signer's certificate merely "
                                         "stands, and stock products believe it"
                                       : "");
  out.report(out_of_it,
             {.rule = is_accepted_by_stock ? Rule::DOC033 : Rule::DOC032,
              .message = message,
              .document = subject.path},
             subject.about);
}

void report(Rule rule, const Subject& subject, const Error& error, const Outcomes& who,
            Diagnosis& out) {
  out.report(who,
             {.rule = rule,
              .message = fmt::format("{}: {}", subject.path.filename().string(), error.message()),
              .document = subject.path},
             subject.about);
}

// Reports that a certificate in the CA file is not marked as a CA.
void report_no_ca(const LoadedFolder& folder, const Subject& subject, const Error& error,
                  Diagnosis& out) {
  out.report(outcomes(subject, measured(Variant::permissions_ca_no_constraints, subject.lineup)),
             {.rule = Rule::DOC035,
              .message = fmt::format("{}: {} in {} does not say that it is a CA ({} expected)",
                                     subject.path.filename().string(), error.details().field,
                                     folder.paths.permissions_ca.filename().string(),
                                     error.details().expected),
              .document = subject.path,
              .hint = std::string(info(Code::not_a_ca).hint)},
             subject.about);
}

// Reports that ddssec accepts the document and a stock product does not. The cause is the CA file.
void report_ca_file(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  out.report(
      outcomes(subject),
      {.rule = Rule::DOC032,
       .message = fmt::format("{}; {} reads the first certificate of {} only, and both stock "
                              "products need the path up to a self-signed CA; it holds {}",
                              who_signed(subject), name(Product::cyclonedds, subject.lineup),
                              folder.paths.permissions_ca.filename().string(), cas_of(folder)),
       .document = subject.path},
      subject.about);
}

// The permissions of an enclave come from a policy, so their hint is about the policy and not about
// signing again.
void report_signature(const LoadedFolder& folder, const Subject& subject, const Error& error,
                      Diagnosis& out) {
  const bool is_permissions = subject.path == folder.paths.permissions;
  out.report(outcomes(subject),
             {.rule = Rule::DOC031,
              .message = fmt::format("{}: {}", subject.path.filename().string(), error.message()),
              .document = subject.path,
              .hint = is_permissions && folder.paths.layout == pki::FolderLayout::sros2
                          ? "a signed file must not be edited: change the policy, then ddssec "
                            "keystore permission KEYSTORE ENCLAVE --policy FILE --node-defaults"
                          : ""},
             subject.about);
}

// If ddssec cannot read the permissions CA file only because of its key (DOC014), stock products
// still check the signature with it.
void diagnose_stock_verdict(const Subject& subject, Diagnosis& out) {
  const Outcomes who{of(subject.cyclonedds_verdict.has_value()),
                     of(subject.fastdds_verdict.has_value()), Outcome::ok};
  if (who.all_ok()) return;
  const auto& verdict =
      subject.cyclonedds_verdict ? subject.fastdds_verdict : subject.cyclonedds_verdict;
  report(Rule::DOC031, subject, verdict.error(), who, out);
}

void diagnose_verdict(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  if (const auto odd = odd_form(subject); !odd.empty())
    return out.report(outcomes_of_form(subject),
                      {.rule = Rule::DOC030, .message = odd, .document = subject.path},
                      subject.about);
  out.pass(Rule::DOC030, subject.about);
  if (!folder.permissions_cas) {
    const bool is_key = folder.permissions_cas.error().code() == Code::key_not_allowed;
    return is_key ? diagnose_stock_verdict(subject, out) : void();
  }
  if (outcomes(subject).all_ok()) return out.pass(Rule::DOC031, subject.about);
  if (subject.our_verdict) return report_ca_file(folder, subject, out);
  const auto& error = subject.our_verdict.error();
  switch (error.code()) {
    case Code::smime_signer_not_permissions_ca:
      return diagnose_signer(folder, subject, out);
    case Code::smime_digest_too_weak:
      return report(Rule::DOC034, subject, error,
                    outcomes(subject, measured(Variant::form_sha1, subject.lineup)), out);
    case Code::key_usage_forbids:
      return report(Rule::DOC035, subject, error,
                    refused_by_ours(Variant::permissions_ca_may_not_sign, subject), out);
    case Code::not_a_ca:
      return report_no_ca(folder, subject, error, out);
    case Code::certificate_expired:
    case Code::certificate_not_yet_valid:
      return;  // the CA's dates have been reported
    default:
      return report_signature(folder, subject, error, out);
  }
}

// The variant for a note of the parser.
std::optional<Variant> variant_of(const Note& note) {
  switch (note.kind) {
    case NoteKind::order:
      return Variant::governance_order;
    case NoteKind::no_name:
      return Variant::grant_without_name;
    case NoteKind::no_default:
      return Variant::grant_without_default;
    case NoteKind::kind_spelling:
      return Variant::governance_small_letters;
    case NoteKind::no_min:
      return Variant::governance_no_min;
    case NoteKind::no_max:
      return Variant::governance_no_max;
    case NoteKind::end_tag_blank:
      return Variant::governance_end_tag_blank;
    case NoteKind::byte_order_mark:
      return Variant::governance_bom;
    case NoteKind::passed_over:
      return Variant::governance_unknown_element;
    case NoteKind::newer_element:
      return Variant::governance_key_revision;
    case NoteKind::tag_of_rule:
      return Variant::permissions_domain_tag;
    case NoteKind::default_namespace:
      return Variant::governance_default_namespace;
    case NoteKind::other_attribute:
    case NoteKind::no_algorithms:
      return Variant::governance_must_interpret;
    case NoteKind::accepted_order:
    case NoteKind::boolean_spelling:
    case NoteKind::padding:
    case NoteKind::refused_padding:
    case NoteKind::refused_spelling:
    case NoteKind::no_zone:
    case NoteKind::fraction:
      return std::nullopt;
  }
  return std::nullopt;
}

// The outcome with stock products for a text that ddssec does not parse.
Outcomes outcomes_of_text(const Subject& subject) {
  Outcomes out{.ddssec = Outcome::fail};
  for (const auto variant : subject.left_out) out = out.worse(measured(variant, subject.lineup));
  // Cyclone DDS joins the pieces. Fast DDS 2.9 reads only the first text, which is another topic,
  // or a value that it refuses.
  if (subject.has_joined_values) out = out.worse({.fastdds = Outcome::unsafe});
  if (subject.is_refused_by_fastdds) out = out.worse({.fastdds = Outcome::fail});
  // It can be parsed once the parts that ddssec does not know are left out.
  if (subject.unread == nullptr) return out;
  const auto outcome = [](bool starts) { return starts ? Outcome::unsafe : Outcome::fail; };
  return out.worse({.cyclonedds = outcome(cyclonedds_starts_with(*subject.unread)),
                    .fastdds = outcome(fastdds_starts_with(*subject.unread))});
}

void report_unreadable(const Subject& subject, Diagnosis& out) {
  if (subject.form.unverified_text.empty())
    return out.report(
        kAllFail,
        {.rule = Rule::DOC036,
         .message = fmt::format("{}: the signed document is empty, 0 octets",
                                subject.path.filename().string()),
         .document = subject.path,
         .hint = fmt::format("write the {} document again and sign it", subject.about)},
        subject.about);
  const auto& error = subject.parsed.error();
  const auto& field = error.details().field;
  out.report(outcomes_of_text(subject),
             {.rule = Rule::DOC036,
              .message = fmt::format("{}: {}{}", subject.path.filename().string(),
                                     field.empty() ? "" : field + ": ", error.message()),
              .document = subject.path,
              .line = error.details().line},
             subject.about);
}

// Reports the first note of each kind in full, with the number of the others.
void report_notes(const Subject& subject, Diagnosis& out) {
  std::map<std::string_view, std::size_t> counts;
  for (const auto& note : *subject.notes) counts[note.text] += 1 + note.more;
  for (const auto& note : *subject.notes) {
    if (note.kind == NoteKind::no_zone || note.kind == NoteKind::fraction)
      continue;  // another rule reports it
    const auto count = std::exchange(counts[note.text], 0);
    if (count == 0) continue;
    const auto variant = variant_of(note);
    auto who = variant ? measured(*variant, subject.lineup) : Outcomes();
    if (note.kind == NoteKind::refused_spelling || note.kind == NoteKind::refused_padding)
      who.fastdds = Outcome::fail;
    const auto more =
        count > 1 ? fmt::format(" (and at {} other place{})", count - 1, count > 2 ? "s" : "")
                  : std::string();
    out.report(who,
               {.rule = Rule::DOC037,
                .message = note.text + more,
                .document = subject.path,
                .line = note.line,
                .severity = who.all_ok() ? Severity::warning : Severity::error},
               subject.about);
  }
}

// True if no product finds a text in the file. The form of the file has been reported. In the other
// forms a product may read a text without octets, which it refuses or crashes on (measured).
bool lacks_text(const pki::DocumentForm& form) {
  using enum pki::DocumentWrapping;
  const bool is_read = form.wrapping == multipart || form.wrapping == opaque;
  return form.unverified_text.empty() && !is_read;
}

void diagnose_text(const Subject& subject, Diagnosis& out) {
  if (lacks_text(subject.form)) return;
  if (!subject.parsed) report_unreadable(subject, out);
  if (subject.notes == nullptr) return;
  if (subject.parsed) out.pass(Rule::DOC036, subject.about);
  out.pass(Rule::DOC037, subject.about);
  report_notes(subject, out);
}

// S/MIME ends lines with CR LF, and editors end files in different ways.
std::string plain_lines(BytesView octets) {
  std::string out(as_text(octets));
  std::erase(out, '\r');
  return out.substr(0, out.find_last_not_of(" \t\n") + 1);
}

// Signing sets the revision, which the XML beside the signed document need not have.
std::string without_revision(std::string text) {
  const auto begin = text.find("<?ddssec ");
  const auto end = begin == text.npos ? text.npos : text.find("?>", begin);
  if (end == text.npos) return text;
  text.erase(begin, std::min(text.find_first_not_of(" \t\n", end + 2), text.size()) - begin);
  return text;
}

// Checks the XML beside a signed document, or beside the target of a link to one. After an edit
// this XML shows rights that are not signed.
void diagnose_plain_text(const Subject& subject, Diagnosis& out) {
  if (subject.form.unverified_text.empty()) return;
  std::error_code failed;
  auto plain = fs::canonical(subject.path, failed).replace_extension("xml");
  if (failed || !fs::is_regular_file(plain, failed)) return;
  const auto octets =
      pki::load_uri("file://" + plain.string(), plain.string(), pki::kMaxDocumentOctets);
  if (!octets || without_revision(plain_lines(*octets)) ==
                     without_revision(plain_lines(subject.form.unverified_text)))
    return;
  out.report({},
             {.rule = Rule::DOC038,
              .message = fmt::format("{} says something else than {}, which is what counts",
                                     name_of(plain), name_of(subject.path)),
              .document = plain,
              .hint = subject.about == "governance"
                          ? "only the signed file counts: sign the XML again if it is the newer "
                            "one (ddssec governance sign " +
                                shell_word(plain.string()) +
                                " --ca CA --replace; CA is the folder with the CAs, or the "
                                "keystore), or delete it"
                          : std::string()},
             subject.about);
}

void diagnose_one(const LoadedFolder& folder, const Subject& subject, Diagnosis& out) {
  diagnose_verdict(folder, subject, out);
  diagnose_text(subject, out);
  diagnose_plain_text(subject, out);
}

void diagnose_size_for_fastdds(const LoadedFolder& folder, const Settings& settings,
                               Diagnosis& out) {
  const auto size = handshake_octets(folder);
  if (size <= kMaxFastDdsHandshakeOctets) return out.pass(Rule::DOC110);
  out.report(
      {.fastdds = Outcome::late},
      {.rule = Rule::DOC110,
       .message = fmt::format(
           "the signed permissions have {} octets, with the certificate {}: participants of {} do "
           "not authenticate one for which these are more than about {} octets",
           folder.permissions.file.size(), size, name(Product::fastdds, settings.lineup),
           kMaxFastDdsHandshakeOctets),
       .document = folder.paths.permissions});
}

}  // namespace

void diagnose_documents(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  if (folder.governance.readable)
    diagnose_one(folder,
                 subject("governance", folder.paths.governance, folder.governance, settings.lineup),
                 out);
  if (!folder.permissions.readable) return;
  diagnose_one(
      folder, subject("permissions", folder.paths.permissions, folder.permissions, settings.lineup),
      out);
  const auto size = folder.permissions.file.size();
  diagnose_size_for_fastdds(folder, settings, out);
  if (size <= pki::kMaxSentPermissionsOctets) return;
  auto finding = too_long_for_peers(size);
  finding.document = folder.paths.permissions;
  out.report({.ddssec = Outcome::fail}, std::move(finding));
}

}  // namespace ddssec::governance::doctor
