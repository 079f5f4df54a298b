#include "cli/agent_response.hpp"

#include <algorithm>
#include <optional>

#include "cli/agent_messages.hpp"
#include "cli/ca_folder.hpp"
#include "cli/documents.hpp"
#include "cli/inputs.hpp"
#include "cli/ocsp_response.hpp"
#include "cli/transaction.hpp"
#include "pki/chain.hpp"
#include "pki/ocsp_fetch.hpp"

namespace ddssec::cli {
namespace {

constexpr std::chrono::minutes kRetry{5};

/// At half of its life: a responder may be down for the other half.
WallTime half_life(const pki::OcspGood& response) {
  return response.this_update() + (response.until() - response.this_update()) / 2;
}

Result<pki::OcspGood> response_in_place(const ResponseTask& task) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets,
                          read_file(ocsp_file(task.files), pki::kMostOcspOctets));
  DDSSEC_ASSIGN_OR_RETURN(auto anchors, read_certificates(task.files.identity_ca));
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, pki::ChainVerifier::make(std::move(anchors)));
  return pki::judge_ocsp(octets, task.certificate, verifier, task.now);
}

Result<pki::OcspGood> renew(const ResponseTask& task, Json& event) {
  DDSSEC_ASSIGN_OR_RETURN(const auto fetched,
                          fetch_response({task.files, task.certificate}, task.now));
  Replacement out;
  DDSSEC_RETURN_IF_ERROR(out.put(ocsp_file(task.files), fetched.octets, 0644));
  DDSSEC_ASSIGN_OR_RETURN(const auto written, out.commit());
  for (const auto& file : written)
    event["files"].push_back({{"path", file.path}, {"mode", file.mode}, {"sha256", file.sha256}});
  return fetched.good;
}

/// The time of a renewed certificate stays: it is what the agent remembers it by.
void look_again_at(WallTime time, Json& event) {
  if (event["event"] == "renewed") return;
  const auto next = time_from(text_in(event, "next"));
  if (!next || time < *next) event["next"] = to_string(time);
}

}  // namespace

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
