// OpenSSL 3.0 calls engines deprecated, but has nothing else for PKCS#11: the providers for it came
// later, and Debian 12 does not have them.
#define OPENSSL_SUPPRESS_DEPRECATED
#include "pki/pkcs11.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include <openssl/engine.h>
#include <openssl/ui.h>

#include "base/background_thread.hpp"
#include "base/uri_source.hpp"
#include "pki/login_ban.hpp"
#include "pki/token_logins.hpp"

namespace ddssec::pki {
namespace {

// PKCS#11 return values (CK_RV), which the engine passes on as OpenSSL's reasons.
constexpr int kPinIncorrect = 0xa0, kPinInvalid = 0xa1, kPinLengthRange = 0xa2, kPinLocked = 0xa4;

// While an object lives, its thread answers the engine with `pin`, but only once.
class PinRequest {
 public:
  explicit PinRequest(const Passphrase* pin) : pin_(pin) { current() = this; }
  ~PinRequest() { current() = nullptr; }
  PinRequest(const PinRequest&) = delete;
  PinRequest& operator=(const PinRequest&) = delete;

  static PinRequest*& current() {
    static thread_local PinRequest* request = nullptr;
    return request;
  }
  const Passphrase* answer() { return std::exchange(asked_, true) ? nullptr : pin_; }
  bool lacked_a_pin() const { return asked_ && pin_ == nullptr; }

 private:
  const Passphrase* pin_;
  bool asked_ = false;
};

int give_pin(UI* ui, UI_STRING* question) {
  if (UI_get_string_type(question) != UIT_PROMPT) return 1;
  auto* const request = PinRequest::current();
  const auto* const pin = request != nullptr ? request->answer() : nullptr;
  if (pin == nullptr) return 0;
  return pin->expose([&](BytesView octets) {
    const auto text = as_text(octets);
    return UI_set_result_ex(ui, question, text.data(), static_cast<int>(text.size())) == 0 ? 1 : 0;
  });
}

// The method is never freed, because keys in use need it until the process ends.
UI_METHOD* pin_method() {
  static UI_METHOD* const method = [] {
    UI_METHOD* made = UI_create_method("PIN of a token");
    if (made != nullptr) UI_method_set_reader(made, give_pin);
    return made;
  }();
  return method;
}

std::atomic<bool> one_wrong_pin_is_all = false;
std::atomic<bool> pin_was_refused = false;

std::atomic<int> forbidding = 0;  // how many login bans apply

Status check_may_log_in(std::string_view uri) {
  if (forbidding > 0) return fail(Code::pkcs11_not_tried, {.found = without_pin(uri)});
  if (!one_wrong_pin_is_all || !pin_was_refused) return {};
  return fail(Code::pkcs11_pin_wrong,
              {.found = without_pin(uri), .note = "not tried: a token has refused a PIN before"});
}

struct Reasons {
  std::string first;
  bool pin_refused = false;
};

// Reads OpenSSL's queue of errors, which is empty afterwards.
Reasons take_reasons() {
  Reasons out;
  while (const auto error = ERR_get_error()) {
    const auto* const text = ERR_reason_error_string(error);
    if (out.first.empty() && text != nullptr) out.first = text;
    const int reason = ERR_GET_REASON(error);
    if (ERR_GET_LIB(error) < ERR_LIB_USER) continue;  // one of OpenSSL's own errors
    out.pin_refused |= reason == kPinIncorrect || reason == kPinInvalid ||
                       reason == kPinLengthRange || reason == kPinLocked;
  }
  return out;
}

// Returns the engine, which is never freed, like the token's keys. After a failure the next call
// tries again, so a module that is installed later is found without a restart.
Result<ENGINE*> engine() {
  static std::mutex mutex;
  static ENGINE* ready = nullptr;
  const std::scoped_lock lock(mutex);
  if (ready != nullptr) return ready;
  ERR_clear_error();
  ENGINE* const made = ENGINE_by_id("pkcs11");
  if (made == nullptr) {
    ERR_clear_error();
    return fail(Code::pkcs11_unavailable, {.note = "OpenSSL has no engine pkcs11"});
  }
  ENGINE_ctrl_cmd_string(made, "QUIET", nullptr, 0);
  if (ENGINE_init(made) != 1) {
    ENGINE_free(made);
    return fail(Code::pkcs11_unavailable, {.note = take_reasons().first});
  }
  ENGINE_free(made);  // the reference of ENGINE_init stays
  // By default the engine asks the user at the terminal, even in a daemon.
  ENGINE_ctrl_cmd(made, "SET_USER_INTERFACE", 0, pin_method(), nullptr, 1);
  return ready = made;
}

std::unexpected<Error> token_error(std::string_view uri, const PinRequest& request) {
  auto reasons = take_reasons();
  ErrorDetails details{.found = without_pin(uri), .note = std::move(reasons.first)};
  if (reasons.pin_refused) pin_was_refused = true;
  if (reasons.pin_refused) return fail(Code::pkcs11_pin_wrong, std::move(details));
  if (request.lacked_a_pin()) return fail(Code::pkcs11_pin_missing, std::move(details));
  return fail(Code::pkcs11_not_found, std::move(details));
}

std::optional<std::string> percent_decoded(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const bool escaped = text.front() == '%';
    const auto octet = escaped ? from_hex(text.substr(1, 2)) : std::nullopt;
    if (escaped && (!octet || octet->size() != 1)) return std::nullopt;
    out += escaped ? static_cast<char>(octet->front()) : text.front();
    text.remove_prefix(escaped ? 3 : 1);
  }
  return out;
}

// A URI without its pin-source, and the PIN from that source.
struct SplitUri {
  std::string uri;
  std::optional<Passphrase> pin;
};

// Returns the position at which the attribute begins; npos if there is none.
std::size_t find_attribute(std::string_view uri, std::string_view name) {
  for (auto at = uri.find(name); at != uri.npos; at = uri.find(name, at + 1))
    if (at > 0 && std::string_view(":;?&").contains(uri[at - 1])) return at;
  return uri.npos;
}

// True if the URI names an object. Without a name, the engine would use the first object in the
// token.
bool names_object(std::string_view uri) {
  return find_attribute(uri, "object=") != uri.npos || find_attribute(uri, "id=") != uri.npos;
}

// Refuses a repeated attribute. RFC 7512 allows each one once, and the engine would use another one
// than this code.
Status check_attributes_once(std::string_view uri) {
  std::set<std::string_view> names;
  for (auto rest = uri.substr(std::string_view("pkcs11:").size());;) {
    const auto end = std::min(rest.find_first_of(";?&"), rest.size());
    const auto attribute = rest.substr(0, end);
    const auto name = attribute.substr(0, attribute.find('='));
    if (!name.empty() && !names.insert(name).second)
      return fail(Code::pkcs11_not_found,
                  {.found = without_pin(uri), .note = "an attribute is given twice"});
    if (end == rest.size()) return {};
    rest.remove_prefix(end + 1);
  }
}

// Splits a URI. The PIN is read here, because the engine would take a line end in the file for a
// part of the PIN, and wrong PINs lock a token.
Result<SplitUri> read_pin_source(std::string_view text) {
  const std::string uri(text.substr(std::min(text.find("pkcs11:"), text.size())));
  constexpr std::string_view kName = "pin-source=";
  if (!names_object(uri))
    return fail(Code::pkcs11_not_found, {.expected = "object= or id=", .found = without_pin(uri)});
  DDSSEC_RETURN_IF_ERROR(check_attributes_once(uri));
  const auto at = find_attribute(uri, kName);
  if (at == uri.npos) return SplitUri{uri, std::nullopt};
  const auto end = std::min(uri.find_first_of("&;", at), uri.size());
  const auto path =
      percent_decoded(std::string_view(uri).substr(at + kName.size(), end - at - kName.size()));
  if (!path)
    return fail(Code::pkcs11_not_found, {.field = "pin-source", .found = without_pin(uri)});
  const bool is_uri = path->starts_with("file:");
  auto pin = load_secret<Passphrase>((is_uri ? "" : "file:") + *path, "pin-source");
  if (!pin) return std::unexpected(pin.error());
  auto without = uri.substr(0, at) + uri.substr(std::min(end + 1, uri.size()));
  return SplitUri{std::move(without),
                  pin->expose([](BytesView octets) {
                       while (!octets.empty() && (octets.back() == '\n' || octets.back() == '\r'))
                         octets = octets.first(octets.size() - 1);
                       return Passphrase::copy_of(octets);
                     })
                      .value()};
}

}  // namespace

void stop_at_first_wrong_pin() { one_wrong_pin_is_all = true; }

LoginBan::LoginBan(bool applies) : applies_(applies) {
  if (applies_) ++forbidding;
}

LoginBan::~LoginBan() {
  if (applies_) --forbidding;
}

Result<PkeyPtr> token_private_key(std::string_view uri, const Passphrase* pin) {
  DDSSEC_RETURN_IF_ERROR(check_may_log_in(uri));
  DDSSEC_ASSIGN_OR_RETURN(const auto split, read_pin_source(uri));
  const SignalBlock blocked;  // a token's module may start threads
  DDSSEC_ASSIGN_OR_RETURN(auto* const token, engine());
  const PinRequest request(split.pin ? &*split.pin : pin);
  ERR_clear_error();
  PkeyPtr key(ENGINE_load_private_key(token, split.uri.c_str(), pin_method(), nullptr));
  if (!key) return token_error(uri, request);
  ERR_clear_error();
  return key;
}

Result<X509Ptr> token_certificate(std::string_view uri) {
  DDSSEC_RETURN_IF_ERROR(check_may_log_in(uri));
  DDSSEC_ASSIGN_OR_RETURN(const auto split, read_pin_source(uri));
  const SignalBlock blocked;  // a token's module may start threads
  DDSSEC_ASSIGN_OR_RETURN(auto* const token, engine());
  const PinRequest request(split.pin ? &*split.pin : nullptr);
  struct {
    const char* uri;
    X509* certificate;
  } wanted{split.uri.c_str(), nullptr};
  ERR_clear_error();
  const bool found = ENGINE_ctrl_cmd(token, "LOAD_CERT_CTRL", 0, &wanted, nullptr, 1) == 1;
  X509Ptr certificate(wanted.certificate);
  if (!found || !certificate) return token_error(uri, request);
  ERR_clear_error();
  return certificate;
}

}  // namespace ddssec::pki
