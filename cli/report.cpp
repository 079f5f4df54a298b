#include "cli/report.hpp"

#include <fmt/format.h>

namespace ddssec::cli {
namespace {

bool is_between(Code code, Code first, Code last) { return first <= code && code <= last; }

// Some hints of the library speak of a participant's properties, which the tool does not have.
std::string_view hint_of(Code code) {
  switch (code) {
    case Code::file_not_found:
      return "check the path";
    case Code::passphrase_wrong:
      return "check what --passphrase-file or --passphrase-env gives";
    case Code::smime_not_multipart:
      return "sign it: ddssec governance sign, ddssec permissions sign";
    default:
      return info(code).hint;
  }
}

// Names from files and the command line must not reach a terminal as control sequences.
std::string printable(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

// The error's sentence without the hint, which stands on its own line.
std::string message(const Error& error) {
  const auto text = printable(error.to_sentence());
  const auto& row = info(error.code());
  const auto tail = fmt::format("; {} [{} {}]", row.hint, row.name, static_cast<int>(error.code()));
  return text.ends_with(tail) ? text.substr(0, text.size() - tail.size()) : text;
}

Json to_json(const Error& error) {
  const auto& row = info(error.code());
  Json out = {{"id", row.name},
              {"number", static_cast<int>(row.code)},
              {"severity", to_string(row.severity)},
              {"message", message(error)}};
  if (!error.details().document.empty()) out["file"] = error.details().document;
  if (error.details().line > 0) out["line"] = error.details().line;
  out["hint"] = hint_of(error.code());
  return out;
}

Json to_json(const WrittenFile& file) {
  return {{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}};
}

template <class T>
Json to_array(const std::vector<T>& values) {
  Json out = Json::array();
  for (const auto& value : values) out.push_back(to_json(value));
  return out;
}

}  // namespace

Exit exit_of(Code code) {
  switch (code) {
    case Code::usage:
    case Code::name_unusable:
    case Code::subject_name_malformed:
      return Exit::usage;
    case Code::would_overwrite:
    case Code::key_readable_by_others:
    case Code::passphrase_needed:
    case Code::passphrase_unusable:
    case Code::passphrase_missing:
    case Code::outlives_ca:
      return Exit::refused;
    case Code::internal:
    case Code::random_failed:
    case Code::file_unwritable:
    case Code::interrupted:
      return Exit::failed;
    case Code::certificate_malformed:
    case Code::certificate_too_large:
    case Code::private_key_malformed:
    case Code::crl_malformed:
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

Report report_of(const Error& error) {
  return {.exit = exit_of(error.code()), .text = {}, .diagnostics = {error}};
}

Json envelope(const Report& report, std::string_view command) {
  return {{"schema", "ddssec/1"},
          {"command", command},
          {"ok", report.exit == Exit::done},
          {"exit", static_cast<int>(report.exit)},
          {"result", report.result},
          {"diagnostics", to_array(report.diagnostics)},
          {"files_written", to_array(report.files_written)}};
}

std::string sentence(const Error& error) {
  const auto& row = info(error.code());
  return fmt::format("ddssec: {} [{} {}]\n  hint: {}\n", message(error), row.name,
                     static_cast<int>(row.code), hint_of(error.code()));
}

}  // namespace ddssec::cli
