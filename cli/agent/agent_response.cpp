#include "cli/agent/agent_response.hpp"

#include <algorithm>

#include "base/tool_code.hpp"
#include "cli/agent/agent_messages.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ocsp_response.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "pki/chain.hpp"
#include "pki/ocsp_fetch.hpp"

namespace ddssec::cli {
namespace {

constexpr std::chrono::minutes kRetry{5};

// The response is fetched at half of its life, so that a responder may be down for the other half.
WallTime half_life(const pki::GoodOcspStatus& response) {
  return response.this_update() + (response.until() - response.this_update()) / 2;
}

Result<pki::GoodOcspStatus> response_in_place(const ResponseTask& task) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(ocsp_file(task.files), pki::kMaxOcspOctets));
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, read_certificates(task.files.identity_ca));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::ChainVerifier::make(std::move(anchors)));
  return pki::judge_ocsp(octets, task.certificate, verifier, task.now);
}

Status check_issued_by_own(const ResponseTask& task) {
  const auto& asked = task.asked;
  const auto issuer_error = [&] {
    return fail(Code::issuer_unknown,
                {.document = task.files.certificate,
                 .expected = "a certificate that a CA of " + asked.cas_source + " has issued",
                 .found = "one of " + task.certificate.issuer(),
                 .note = "so the OCSP responder that it names is not asked"});
  };
  if (asked.asks_none) return issuer_error();
  if (asked.cas_pem.empty()) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto cas,
                          pki::Certificate::bundle_from_pem(as_bytes(asked.cas_pem)));
  const auto is_issuer = [&](const auto& ca) { return task.certificate.is_issued_by(ca); };
  if (std::ranges::none_of(cas, is_issuer)) return issuer_error();
  return {};
}

Status check_may_ask(const ResponseTask& task) {
  DDSSEC_RETURN_IF_ERROR(check_issued_by_own(task));
  const auto url = pki::ocsp_responder_of(task.certificate);
  const auto& silent_urls = task.asked.silent_urls;
  if (std::ranges::find(silent_urls, url) == silent_urls.end()) return {};
  return fail(tool_code::ocsp_fetch_failed,
              {.found = url,
               .note = "it did not answer another folder's request; it is asked again within five "
                       "minutes"});
}

Result<pki::GoodOcspStatus> renew(const ResponseTask& task, Json& event) {
  DDSSEC_RETURN_IF_ERROR(check_may_ask(task));
  const auto fetched = fetch_response({task.files, task.certificate}, task.now);
  if (!fetched) {
    if (fetched.error().code() == tool_code::ocsp_fetch_failed)
      event["ocsp_silent"] = pki::ocsp_responder_of(task.certificate);
    return std::unexpected(fetched.error());
  }
  FileTransaction out;
  DDSSEC_RETURN_IF_ERROR(out.put(ocsp_file(task.files), fetched->octets, 0644));
  DDSSEC_ASSIGN_OR_RETURN(const auto written, out.commit());
  for (const auto& file : written)
    event["files"].push_back({{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}});
  return fetched->good;
}

// Moves "next" to `time` if that is earlier. The time of a renewed certificate stays, because the
// agent stores it as the renewal time of that certificate.
void look_again_at(WallTime time, Json& event) {
  if (event["event"] == "renewed") return;
  const auto next = time_from(text_in(event, "next"));
  if (!next || time < *next) event["next"] = to_string(time);
}

}  // namespace

AskedResponders asked_responders(const Arguments& arguments, bool is_own) {
  const bool is_by_ca = arguments.has("--ca");
  AskedResponders out{.cas_source = is_by_ca ? "--ca" : "--trust"};
  if (!is_by_ca && !arguments.has("--trust")) {
    out.asks_none = !is_own;
    return out;
  }
  const auto cas =
      read_certificates(is_by_ca ? ca_paths(arguments.text("--ca"), "identity").certificate
                                 : std::filesystem::path(arguments.text("--trust")));
  if (cas) out.cas_pem = to_pem(*cas);
  out.asks_none = !cas;
  return out;
}

void keep_response(const ResponseTask& task, Json& event) {
  if (pki::ocsp_responder_of(task.certificate).empty()) return;
  auto response = response_in_place(task);
  if (!response || half_life(*response) <= task.now) {
    response = renew(task, event);
    if (response && event["event"] == "current") event["event"] = "ocsp_renewed";
  }
  if (response) {
    event["ocsp_until"] = to_string(response->until());
    return look_again_at(std::max(half_life(*response), task.now + kRetry), event);
  }
  if (!event.contains("problem")) event["problem"] = error_to_json(response.error());
  look_again_at(task.now + kRetry, event);
}

}  // namespace ddssec::cli
