#include "cli/inputs.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/errno_text.hpp"
#include "base/hash.hpp"
#include "base/tool_code.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/held_folder.hpp"
#include "governance/date_time.hpp"
#include "pki/certificate_source.hpp"
#include "pki/ocsp_address.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPassphraseLine = pki::Passphrase::capacity + 2;

std::string uri(const fs::path& path) { return "file://" + path.string(); }

// A file may have been read by the path of its folder's descriptor, which users cannot understand.
std::unexpected<Error> error_in_file(const Error& error, const fs::path& path) {
  return std::unexpected(pki::about_file(pki::about_file(error, path_in_held_folder(path)), path));
}

std::string_view without_line_end(std::string_view text) {
  if (text.ends_with('\n')) text.remove_suffix(1);
  if (text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

Result<pki::Passphrase> passphrase_from(std::string_view text) {
  if (text.empty() || text.size() > pki::Passphrase::capacity)
    return fail(Code::passphrase_unusable);
  return pki::Passphrase::copy_of(as_bytes(text));
}

// Reads one line octet by octet, because the rest of the stream does not belong to this command.
Result<pki::Passphrase> passphrase_from_stream(int file) {
  std::array<std::uint8_t, kMaxPassphraseLine> line{};
  std::size_t size = 0;
  while (size < line.size() && ::read(file, &line[size], 1) == 1)
    if (line[size++] == '\n') break;
  auto out = passphrase_from(without_line_end(as_text(BytesView(line).first(size))));
  wipe(line);
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  return out;
}

// Reads from a pipe of the shell, such as --passphrase-file <(pass show ca).
Result<pki::Passphrase> passphrase_from_pipe(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return fail(Code::file_unreadable, {.document = path, .note = errno_text(errno)});
  auto out = passphrase_from_stream(file);
  ::close(file);
  return out;
}

Result<pki::Passphrase> passphrase_from_file(const std::string& path) {
  if (path == "-") return passphrase_from_stream(STDIN_FILENO);
  std::error_code ignored;
  if (fs::is_fifo(path, ignored)) return passphrase_from_pipe(path);
  DDSSEC_ASSIGN_OR_RETURN(auto octets, read_file(path, kMaxPassphraseLine));
  auto out = passphrase_from(without_line_end(as_text(octets)));
  wipe(octets);
  return out;
}

std::optional<std::chrono::seconds> duration_from(std::string_view text) {
  int number = 0;
  const auto* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || number < 0 || number > 100'000) return std::nullopt;
  const std::string_view unit(at, static_cast<std::size_t>(end - at));
  if (unit.empty() || unit == "d") return std::chrono::days(number);
  if (unit == "h") return std::chrono::hours(number);
  if (unit == "w") return std::chrono::weeks(number);
  return std::nullopt;
}

class EchoOff {
 public:
  EchoOff() {
    if (::tcgetattr(STDIN_FILENO, &before_) != 0) return;
    auto quiet = before_;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    known_ = ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &quiet) == 0;
  }
  ~EchoOff() {
    if (known_) ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before_);
    std::fputc('\n', stderr);
  }
  EchoOff(const EchoOff&) = delete;
  EchoOff& operator=(const EchoOff&) = delete;

 private:
  termios before_{};
  bool known_ = false;
};

Result<pki::Passphrase> typed_passphrase(const char* prompt) {
  std::fputs(prompt, stderr);
  const EchoOff echo_off;
  return passphrase_from_stream(STDIN_FILENO);
}

}  // namespace

Result<Bytes> read_file(const fs::path& path, std::size_t max_octets) {
  auto octets = pki::load(uri(path_in_held_folder(path)), "", max_octets);
  if (!octets) return error_in_file(octets.error(), path);
  return octets;
}

bool path_exists(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path_in_held_folder(path), ignored);
}

Status check_directory(const fs::path& folder, std::string_view expected) {
  std::error_code error;
  const auto type = fs::status(folder, error).type();
  if (type == fs::file_type::directory) return {};
  ErrorDetails details{.document = folder, .expected = std::string(expected)};
  if (type == fs::file_type::not_found) return fail(Code::file_not_found, std::move(details));
  if (type == fs::file_type::none)
    details.note = error.message();
  else
    details.found = "a file";
  return fail(Code::file_unreadable, std::move(details));
}

Result<pki::Certificate> read_certificate(const fs::path& path) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(path, pki::kMaxCertificateOctets));
  auto certificate = pki::Certificate::from_pem(octets);
  if (!certificate) return error_in_file(certificate.error(), path);
  return certificate;
}

Result<pki::Passphrase> passphrase(const Arguments& arguments, Typed typed, const char* prompt) {
  if (arguments.has("--passphrase-file"))
    return passphrase_from_file(arguments.text("--passphrase-file"));
  if (arguments.has("--passphrase-env")) {
    const auto name = arguments.text("--passphrase-env");
    if (const char* value = std::getenv(name.c_str())) return passphrase_from(value);
    return fail(Code::passphrase_unusable,
                {.note = "the environment variable " + name + " is not set",
                 .hint = "set and export it; or give --passphrase-file FILE"});
  }
  if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDERR_FILENO) == 0)
    return fail(Code::passphrase_needed);
  DDSSEC_ASSIGN_OR_RETURN(auto first, typed_passphrase(prompt));
  if (typed == Typed::once) return first;
  DDSSEC_ASSIGN_OR_RETURN(const auto second, typed_passphrase("the same again: "));
  return first == second ? Result<pki::Passphrase>(std::move(first))
                         : fail(Code::passphrase_unusable);
}

std::optional<Error> passphrase_warning(const Arguments& arguments) {
  if (!arguments.has("--passphrase-file")) return std::nullopt;
  const auto path = arguments.text("--passphrase-file");
  struct stat status {};
  if (path == "-" || ::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) ||
      (status.st_mode & 077) == 0)
    return std::nullopt;
  return Error(Code::passphrase_readable_by_others,
               {.document = path,
                .expected = "mode 0600",
                .found = fmt::format("mode {:04o}", status.st_mode & 07777)});
}

fs::path ca_folder(const fs::path& folder, std::string_view role) {
  std::error_code ignored;
  return fs::exists(folder / "ca.pem", ignored) ? folder : folder / role;
}

Result<pki::PrivateKey> read_key(const fs::path& path, const pki::Passphrase* passphrase) {
  const auto uri = pki::uri_of(path_in_held_folder(path));
  if (!uri) return error_in_file(uri.error(), path);
  auto key = pki::PrivateKey::load(*uri, "", passphrase);
  if (!key) return error_in_file(key.error(), path);
  return key;
}

Result<bool> is_encrypted(const fs::path& key) {
  const auto pem = load_secret<pki::KeyPem>(uri(path_in_held_folder(key)), "");
  if (!pem) return error_in_file(pem.error(), key);
  return pem->expose([](BytesView octets) {
    const auto text = as_text(octets);
    return text.find("BEGIN ENCRYPTED") != text.npos || text.find(",ENCRYPTED") != text.npos;
  });
}

std::optional<WallTime> time_from(std::string_view text) {
  constexpr std::size_t kDate = std::string_view("2026-11-21").size();
  const auto whole = text.size() == kDate ? std::string(text) + "T00:00:00Z" : std::string(text);
  const auto time = governance::parse_date_time(whole, governance::Round::down);
  return time ? std::optional(time->time) : std::nullopt;
}

std::optional<WallTime> time_from(std::string_view text, WallTime now) {
  if (!text.starts_with('+') && !text.starts_with('-')) return time_from(text);
  const auto distance = duration_from(text.substr(1));
  if (!distance) return std::nullopt;
  const auto time = text.starts_with('+') ? now + *distance : now - *distance;
  return time < WallTime{} ? std::nullopt : std::optional(time);
}

Result<std::chrono::seconds> duration(const Arguments& arguments, std::string_view option) {
  const auto text = arguments.text(option);
  if (const auto out = duration_from(text)) return *out;
  return fail(Code::usage, {.field = std::string(option),
                            .expected = "a time such as 30d, 12h or 4w",
                            .found = '"' + text + '"'});
}

pki::Validity validity_of(int days, WallTime now) {
  return {now - kBackdated, now + std::chrono::days(days)};
}

Result<std::string> ocsp_responder(const Arguments& arguments) {
  constexpr std::size_t kMaxOctets = 512;
  auto url = arguments.text("--ocsp-responder");
  if (url.empty()) return url;
  const auto address = pki::parse_ocsp_address(url);
  if (address && url.size() <= kMaxOctets) return url;
  return fail(Code::usage,
              {.field = "--ocsp-responder",
               .expected = fmt::format("an http:// URL of at most {} octets", kMaxOctets),
               .found = url.substr(0, kMaxOctets),
               .note = address ? "" : address.error().details().note});
}

Result<pki::Validity> validity(const Arguments& arguments, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto days, arguments.number("--days", 1, kMaxDays));
  return validity_of(days, now);
}

pki::Validity validity_after(const pki::Certificate& former, pki::Validity wanted, WallTime now) {
  if (former.not_before() <= now)
    wanted.not_before = std::max(wanted.not_before, former.not_before());
  return wanted;
}

Result<pki::KeySpec> key_spec_of(std::string_view key, std::string_view field) {
  if (key == "p256") return pki::KeySpec{};
  if (key == "rsa2048") return pki::KeySpec{pki::KeyKind::rsa, 2048};
  if (key == "rsa3072") return pki::KeySpec{pki::KeyKind::rsa, 3072};
  return fail(Code::usage, {.field = std::string(field),
                            .expected = "p256, rsa2048 or rsa3072",
                            .found = std::string(key)});
}

Result<pki::KeySpec> key_spec(const Arguments& arguments) {
  return key_spec_of(arguments.text("--key"), "--key");
}

Result<pki::PrivateKey> token_key(const std::string& uri, const Arguments& arguments) {
  const bool names_pin = uri.contains("pin-source=") || uri.contains("pin-value=");
  if (names_pin) return pki::PrivateKey::load(uri, "");
  DDSSEC_ASSIGN_OR_RETURN(const auto pin, passphrase(arguments, Typed::once, "PIN of the token: "));
  return pki::PrivateKey::load(uri, "", &pin);
}

Result<NewKey> new_key(const Arguments& arguments) {
  const auto wanted = arguments.text("--key");
  if (names_token(wanted)) {
    DDSSEC_ASSIGN_OR_RETURN(auto private_key, token_key(wanted, arguments));
    return NewKey{std::move(private_key), wanted};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto spec, key_spec(arguments));
  DDSSEC_ASSIGN_OR_RETURN(auto private_key, pki::PrivateKey::generate(spec.kind, spec.bits));
  return NewKey{std::move(private_key), {}};
}

fs::path certificate_path(const fs::path& given) {
  std::error_code ignored;
  return fs::is_directory(given, ignored) ? pki::participant_folder(given).certificate : given;
}

Status confirm(const std::string& question) {
  if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDERR_FILENO) == 0)
    return fail(Code::confirmation_needed, {.note = question});
  std::fputs(fmt::format("{} [y/N] ", question).c_str(), stderr);
  char answer = 0;
  const bool said = ::read(STDIN_FILENO, &answer, 1) == 1;
  DDSSEC_RETURN_IF_ERROR(check_not_interrupted());
  if (said && (answer == 'y' || answer == 'Y')) return {};
  return fail(tool_code::not_confirmed, {.note = question});
}

std::string folder_name(const fs::path& folder) {
  const auto clean = folder.lexically_normal();
  return (clean.has_filename() ? clean : clean.parent_path()).filename().string();
}

Result<std::vector<std::string>> read_topics(const fs::path& file) {
  constexpr std::size_t kMaxOctets = 4 * 1024 * 1024;
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, kMaxOctets));
  std::vector<std::string> out;
  std::string_view rest = as_text(octets);
  while (!rest.empty()) {
    const auto end = std::min(rest.find('\n'), rest.size());
    auto line = rest.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (!line.empty() && line.front() != '#') out.emplace_back(line);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (!out.empty()) return out;
  return fail(Code::usage,
              {.document = file, .field = "--topics", .expected = "a topic on each line"});
}

Status check_name(std::string_view name, std::string_view any_other) {
  constexpr std::size_t kMax = 64;  // the limit of a common name, ub-common-name of X.520
  const auto is_letter_or_digit = [](char c) {
    return ('a' <= c && c <= 'z') || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9');
  };
  const auto is_fine = [&](char c) {
    return is_letter_or_digit(c) || c == '.' || c == '_' || c == '-';
  };
  if (!name.empty() && name.size() <= kMax && is_letter_or_digit(name[0]) &&
      std::ranges::all_of(name, is_fine))
    return {};
  ErrorDetails details{.found = '"' + std::string(name.substr(0, kMax)) + '"'};
  if (!any_other.empty()) {
    const auto hint = info(Code::name_unusable).hint;  // the hint's last clause is about --subject
    details.hint = fmt::format("{}; {}", hint.substr(0, hint.rfind("; ")), any_other);
  }
  return fail(Code::name_unusable, std::move(details));
}

std::string date(WallTime time) { return to_string(time).substr(0, 10); }

}  // namespace ddssec::cli
