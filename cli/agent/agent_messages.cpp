#include "cli/agent/agent_messages.hpp"

#include <algorithm>
#include <cerrno>
#include <unistd.h>

#include "base/code.hpp"
#include "cli/frame/notices.hpp"

namespace ddssec::cli {
namespace {

std::unexpected<Error> malformed_message_error() {
  return fail(Code::internal, {.field = "a process of the agent", .note = "an unclear message"});
}

Result<Bytes> octets_in(const Json& json, std::string_view name) {
  auto out = from_hex(text_in(json, name));
  if (!out) return malformed_message_error();
  return *std::move(out);
}

}  // namespace

// Writes ASCII only, so that the text cannot control a terminal.
std::string to_line(const Json& value) {
  return value.dump(-1, ' ', true, Json::error_handler_t::replace);
}

Result<Json> json_from(std::string_view line) {
  auto out = Json::parse(line, nullptr, false);
  if (!out.is_object()) return malformed_message_error();
  return out;
}

int send_line(int out, const Json& value) {
  const auto line = to_line(value) + '\n';
  for (std::string_view rest = line; !rest.empty();) {
    const auto written = ::write(out, rest.data(), rest.size());
    if (written < 0 && errno != EINTR) return 1;
    if (written > 0) rest.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void add_notice_to(Json& line, const std::string& member) {
  const auto notices = take_notices();
  if (!notices.empty() && !line.contains(member)) line[member] = error_to_json(notices.front());
}

Json error_line(const Error& error) { return {{"error", error_to_json(error)}}; }

std::string text_in(const Json& json, std::string_view name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::int64_t number_in(const Json& json, std::string_view name) {
  const auto found = json.find(name);
  return found != json.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

Json to_json(const RenewalRequest& request) {
  return {{"request", request.request},
          {"certificate", request.certificate},
          {"permissions", to_hex(request.permissions)},
          {"lifetime", request.lifetime.count()},
          {"only_permissions", int(request.is_only_for_permissions)}};
}

Result<RenewalRequest> request_from(const Json& json) {
  DDSSEC_ASSIGN_OR_RETURN(auto permissions, octets_in(json, "permissions"));
  return RenewalRequest{.request = text_in(json, "request"),
                        .certificate = text_in(json, "certificate"),
                        .permissions = std::move(permissions),
                        .lifetime = std::chrono::seconds(number_in(json, "lifetime")),
                        .is_only_for_permissions = number_in(json, "only_permissions") != 0};
}

Json to_json(const RenewalAnswer& answer) {
  Json out = {{"certificate", answer.certificate}, {"permissions", to_hex(answer.permissions)}};
  if (answer.problem) out["problem"] = error_to_json(*answer.problem);
  if (!answer.renewals.empty()) out["renewals"] = answer.renewals;
  return out;
}

std::string answer_line(RenewalAnswer& answer) {
  auto out = to_line(to_json(answer)) + '\n';
  if (out.size() <= kMaxAgentLine || answer.renewals.empty()) return out;
  answer.renewals.clear();
  return to_line(to_json(answer)) + '\n';
}

Result<RenewalAnswer> answer_from(const Json& json) {
  if (json.contains("error")) return std::unexpected(reported_error(json["error"]));
  DDSSEC_ASSIGN_OR_RETURN(auto permissions, octets_in(json, "permissions"));
  RenewalAnswer out{.certificate = text_in(json, "certificate"),
                    .permissions = std::move(permissions),
                    .renewals = text_in(json, "renewals")};
  if (json.contains("problem")) out.problem = reported_error(json["problem"]);
  if (json.contains("notice")) out.notice = reported_error(json["notice"]);
  return out;
}

Json to_json(const DocumentRequest& request) {
  return {{"wanted", request.wanted},
          {"request", request.request},
          {"certificate", request.certificate}};
}

DocumentRequest document_request_from(const Json& json) {
  return {text_in(json, "wanted"), text_in(json, "request"), text_in(json, "certificate")};
}

Json document_line(BytesView document) { return {{"document", to_hex(document)}}; }

Result<Bytes> document_from(const Json& json) {
  if (json.contains("error")) return std::unexpected(reported_error(json["error"]));
  return octets_in(json, "document");
}

Json error_to_json(const Error& error) {
  const auto& details = error.details();
  return {{"code", static_cast<int>(error.code())},
          {"document", details.document},
          {"line", details.line},
          {"field", details.field},
          {"expected", details.expected},
          {"found", details.found},
          {"note", details.note},
          {"hint", details.hint}};
}

Error reported_error(const Json& json) {
  if (!json.is_object()) return Error(Code::internal);
  const auto code = static_cast<Code>(number_in(json, "code"));
  const auto found = std::ranges::find(all_codes(), code, &CodeInfo::code);
  return Error(found == all_codes().end() ? Code::internal : found->code,
               {.document = text_in(json, "document"),
                .line = static_cast<int>(number_in(json, "line")),
                .field = text_in(json, "field"),
                .expected = text_in(json, "expected"),
                .found = text_in(json, "found"),
                .note = text_in(json, "note"),
                .hint = text_in(json, "hint")});
}

}  // namespace ddssec::cli
