#include "cli/frame/report.hpp"

#include <fmt/format.h>

#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/explain_severities.hpp"
#include "cli/frame/missing_path.hpp"

namespace ddssec::cli {
namespace {

bool is_between(Code code, Code first, Code last) { return first <= code && code <= last; }

// Some hints of the library mention a participant's properties, which the tool does not have.
std::string_view tool_hint_of(Code code) {
  switch (code) {
    case Code::file_not_found:
      return "check the path";
    case Code::file_unreadable:
      return "check that it is of the kind that is expected, and that you may read it and enter "
             "the "
             "folders above it";
    case Code::passphrase_wrong:
      return "check what --passphrase-file or --passphrase-env gives";
    case Code::smime_not_multipart:
      return "sign it: ddssec governance sign, ddssec permissions sign";
    default:
      return {};
  }
}

// An error or a finding, as text and JSON show it.
struct Diagnostic {
  std::string_view id;
  Severity severity;
  std::string message;
  std::string file;
  int line;
  std::string path;
  std::string hint;
  std::vector<std::string> products;
};

// For an error in the command line, the details say everything, so the code's summary is left out.
std::string message_of(const Error& error) {
  const auto& details = error.details();
  if (error.code() != Code::usage) return error.message();
  std::string out;
  const auto add = [&](std::string_view before, std::string_view text) {
    if (!text.empty())
      out += fmt::format("{}{}{}", out.empty() ? "" : before.empty() ? "; " : ", ", before, text);
  };
  add("expected ", details.expected);
  add("found ", details.found);
  add("", details.note);
  return out.empty() ? error.message() : out;
}

Diagnostic diagnostic(const Error& error, const std::string& help_on) {
  const auto& row = info(error.code());
  const auto& details = error.details();
  const auto message = details.field.empty()
                           ? message_of(error)
                           : fmt::format("{}: {}", details.field, message_of(error));
  return {row.name, severity_in_tool(error.code()), message, details.document, details.line,
          {},       hint_of(error, help_on),        {}};
}

Diagnostic diagnostic(const Finding& finding) {
  const auto& row = info(finding.rule);
  return {row.id,
          finding.severity,
          finding.message,
          finding.document,
          finding.line,
          finding.path,
          finding.hint.empty() ? std::string(row.hint) : finding.hint,
          finding.products};
}

std::vector<Diagnostic> diagnostics_of(const Report& report) {
  std::vector<Diagnostic> out;
  for (const auto& error : report.errors) out.push_back(diagnostic(error, report.help_on));
  for (const auto& finding : report.findings) out.push_back(diagnostic(finding));
  return out;
}

// Returns the escape sequence for bold red, yellow or cyan.
std::string_view color_of(Severity severity) {
  if (severity >= Severity::error) return "\033[1;31m";
  return severity == Severity::warning ? "\033[1;33m" : "\033[1;36m";
}

std::string to_text(const Diagnostic& d, bool color) {
  auto out =
      fmt::format("{}{}[{}]:{} {}\n", color ? color_of(d.severity) : "", severity_word(d.severity),
                  d.id, color ? "\033[0m" : "", printable(d.message));
  if (!d.file.empty())
    out += fmt::format("  --> {}{}\n", printable(d.file),
                       d.line > 0 ? fmt::format(":{}", d.line) : std::string());
  if (!d.products.empty()) out += fmt::format("  concerns: {}\n", fmt::join(d.products, ", "));
  return out + fmt::format("  hint: {}\n", printable(d.hint));
}

Json to_json(const Diagnostic& d) {
  Json out = {
      {"id", d.id}, {"severity", severity_word(d.severity)}, {"message", printable(d.message)}};
  if (!d.file.empty()) out["file"] = d.file;
  if (d.line > 0) out["line"] = d.line;
  if (!d.path.empty()) out["path"] = d.path;
  out["hint"] = d.hint;
  if (!d.products.empty()) out["vendors"] = d.products;
  return out;
}

Json to_json(const WrittenFile& file) {
  if (!file.link_to.empty())
    return {{"path", file.path}, {"mode", file.mode}, {"link_to", file.link_to}};
  Json out = {{"path", file.path}, {"mode", file.mode}};
  if (!file.sha256.empty()) out["sha256"] = file.sha256;
  return out;
}

template <class T>
Json to_array(const std::vector<T>& values) {
  Json out = Json::array();
  for (const auto& value : values) out.push_back(to_json(value));
  return out;
}

}  // namespace

std::string hint_of(const Error& error, const std::string& help_on) {
  const auto& details = error.details();
  if (error.code() == Code::file_not_found && details.hint.empty())
    if (const auto words = missing_path_hint(details.document); !words.empty())
      return fmt::format("{}: {}", tool_hint_of(error.code()), words);
  const auto own = tool_hint_of(error.code());
  if (!error.details().hint.empty() || own.empty()) {
    const bool is_general = error.code() == Code::usage && error.details().hint.empty();
    return is_general && !help_on.empty() ? fmt::format("ddssec {} --help says more", help_on)
                                          : error.hint();
  }
  return std::string(own);
}

// Tools that read diagnostics know only three words.
std::string_view severity_word(Severity severity) {
  if (severity >= Severity::error) return "error";
  return severity == Severity::warning ? "warning" : "note";
}

Exit exit_of(Code code) {
  if (code == tool_code::keystore_unseen ||
      is_between(code, tool_code::status_not_shown, tool_code::status_unanswered))
    return Exit::unreadable;
  if (code == tool_code::not_confirmed || code == tool_code::folder_untrusted ||
      code == tool_code::ends_before_ca || code == tool_code::hook_unsafe ||
      code == tool_code::trust_unsafe || code == tool_code::link_untrusted ||
      code == tool_code::status_folder_untrusted)
    return Exit::refused;
  if (code == tool_code::interrupted_between_files) return Exit::failed;
  switch (code) {
    case Code::usage:
    case Code::name_unusable:
    case Code::enclave_name_unusable:
    case Code::subject_name_malformed:
      return Exit::usage;
    case Code::would_overwrite:
    case Code::key_readable_by_others:
    case Code::passphrase_needed:
    case Code::passphrase_unusable:
    case Code::passphrase_missing:
    case Code::outlives_ca:
    case Code::confirmation_needed:
    case Code::subject_taken:
    case Code::unfinished_untrusted:
      return Exit::refused;
    case Code::internal:
    case Code::random_failed:
    case Code::file_unwritable:
    case Code::interrupted:
      return Exit::failed;
    case Code::issue_log_malformed:
    case Code::fleet_malformed:
    case Code::keystore_incomplete:
    case Code::capture_unreadable:
    case Code::certificate_malformed:
    case Code::certificate_too_large:
    case Code::certificate_distribution_points:
    case Code::private_key_malformed:
    case Code::crl_malformed:
    case Code::crl_is_delta:
    case Code::smime_malformed:
    case Code::smime_not_multipart:
      return Exit::unreadable;
    default:
      break;
  }
  const bool is_input = is_between(code, Code::file_not_found, Code::file_too_large) ||
                        code == Code::item_empty ||
                        is_between(code, Code::xml_too_large, Code::too_many_rules);
  return is_input ? Exit::unreadable : Exit::no;
}

namespace {

// Adds the command that reads a document which was given to the wrong command.
Error with_right_command(const Error& error) {
  auto details = error.details();
  for (const auto& [body, kind] : {std::pair("<permissions>", "permissions"),
                                   std::pair("<domain_access_rules>", "governance")})
    if (details.found == body)
      details.hint =
          fmt::format("it is a {0} document: ddssec {0} --help lists what reads it", kind);
  return Error(error.code(), std::move(details));
}

}  // namespace

Report report_of(const Error& error) {
  return {.exit = exit_of(error.code()),
          .text = {},
          .errors = {error.code() == Code::document_kind ? with_right_command(error) : error}};
}

Json envelope(const Report& report, std::string_view command) {
  return {{"schema", "ddssec/2"},
          {"command", command},
          {"ok", report.exit == Exit::done},
          {"exit", static_cast<int>(report.exit)},
          {"result", report.result},
          {"diagnostics", to_array(diagnostics_of(report))},
          {"files_written", to_array(report.files_written)}};
}

std::string diagnostics_text(const Report& report, Style style) {
  std::string out;
  for (const auto& d : diagnostics_of(report))
    if (!style.quiet || d.severity >= Severity::error) out += to_text(d, style.color);
  if (style.verbose)
    for (const auto& file : report.files_written)
      out += fmt::format("wrote {} {}  {}\n", file.mode, printable(file.path),
                         file.link_to.empty() ? file.sha256 : "-> " + file.link_to);
  return out;
}

std::string count_text(std::size_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

std::string dry_run_text(const Report& report) {
  std::string out = "dry run: nothing was written\n";
  for (const auto& file : report.files_written)
    out += fmt::format("would write {} {}{}\n", file.mode, printable(file.path),
                       file.link_to.empty() ? "" : " -> " + file.link_to);
  return out + report.forecast;
}

}  // namespace ddssec::cli
