// inspect: shows the network traffic, and where participants that should communicate get stuck.
#include <algorithm>

#include <fmt/format.h>

#include "cli/capture.hpp"
#include "cli/commands/groups.hpp"
#include "cli/frame/progress.hpp"
#include "cli/frame/transaction.hpp"
#include "pki/certificate.hpp"
#include "rtps/observer/frames.hpp"
#include "rtps/observer/meetings.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::cli {
namespace {

using rtps::MeetingState;

constexpr int kLongest = 86'400;

/// CryptoTransformKind (DDS-Security 1.2, clause 10.5.2.1.1), whatever its key revision.
std::string kind_name(TransformKind kind) {
  switch (kind.octets[3]) {
    case 1:
      return "AES128-GMAC";
    case 2:
      return "AES128-GCM";
    case 3:
      return "AES256-GMAC";
    case 4:
      return "AES256-GCM";
    default:
      return "kind " + kind.to_string();
  }
}

std::vector<std::string> kinds_of(const rtps::ObservedParticipant& participant) {
  std::vector<std::string> out;
  for (const auto& kind : participant.kinds)
    if (auto name = kind_name(kind); std::ranges::find(out, name) == out.end())
      out.push_back(std::move(name));
  return out;
}

std::optional<rtps::CertificateNames> names_in(BytesView pem) {
  const auto certificate = pki::Certificate::from_pem(pem);
  if (!certificate) return std::nullopt;
  return rtps::CertificateNames{certificate->subject(), certificate->issuer()};
}

double milliseconds(MonotonicTime time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

// ---- for people

std::string text_of(const GuidPrefix& prefix, const rtps::ObservedParticipant& participant) {
  auto out =
      fmt::format("{}\n  {} at {}, {}GUID prefix {}\n", name_of(prefix, participant),
                  name_of(participant.vendor), fmt::join(participant.addresses, ", "),
                  participant.domain < 0 ? "" : fmt::format("domain {}, ", participant.domain),
                  prefix.to_string());
  if (!participant.data) return out + "  did not announce itself\n";
  if (participant.is_secured()) {
    const auto issuer = issuer_of(participant);
    out += fmt::format("  identity     {}\n",
                       issuer.empty() ? "not said before the handshake" : "issued by " + issuer);
    const auto info = participant.data->security_info.value_or(spi::SecurityInfo{});
    if (const auto kinds = spi::attributes_in(info))
      out += fmt::format("  protection   rtps {}, discovery {}, liveliness {}\n",
                         to_string(kinds->rtps), to_string(kinds->discovery),
                         to_string(kinds->liveliness));
  } else {
    out += "  identity     none: it is not secured\n";
  }
  out += fmt::format(
      "  sent         {} messages, {} protected whole, {} submessages protected{}{}\n",
      participant.messages.count, participant.protected_messages, participant.protected_submessages,
      participant.kinds.empty() ? "" : ", ", fmt::join(kinds_of(participant), ", "));
  if (participant.clear_samples + participant.clear_topics.size() > 0)
    out += fmt::format("  in the clear {}, {}\n", counted(participant.clear_samples, "sample"),
                       counted(participant.clear_topics.size(), "topic"));
  return out;
}

std::string text_of(const rtps::Meeting& meeting, const rtps::Observer& observer) {
  const auto name = [&](const GuidPrefix& prefix) {
    return name_of(prefix, observer.participants().at(prefix));
  };
  auto out = fmt::format(
      "{} and {}: {}", name(meeting.a), name(meeting.b),
      meeting.state == MeetingState::apart ? "they do NOT talk" : to_string(meeting.state));
  if (meeting.took) out += fmt::format(" within {:.0f} ms", milliseconds(*meeting.took));
  return out + '\n';
}

// ---- for machines

Json to_json(const GuidPrefix& prefix, const rtps::ObservedParticipant& participant) {
  Json out = {{"guid_prefix", prefix.to_string()},
              {"name", name_of(prefix, participant)},
              {"vendor", name_of(participant.vendor)},
              {"domain", participant.domain < 0 ? Json(nullptr) : Json(participant.domain)},
              {"addresses", participant.addresses},
              {"announced", participant.data.has_value()},
              {"secured", participant.is_secured()},
              {"certificate", nullptr},
              {"protection", nullptr},
              {"messages", participant.messages.count},
              {"protected_messages", participant.protected_messages},
              {"protected_submessages", participant.protected_submessages},
              {"kinds", kinds_of(participant)},
              {"clear_samples", participant.clear_samples},
              {"encrypted_payloads", participant.encrypted_payloads},
              {"clear_topics", Json::array()},
              {"left", participant.left}};
  if (participant.certificate)
    out["certificate"] = {{"subject", participant.certificate->subject},
                          {"issuer", participant.certificate->issuer}};
  if (participant.data && participant.data->security_info)
    if (const auto kinds = spi::attributes_in(*participant.data->security_info))
      out["protection"] = {{"rtps", to_string(kinds->rtps)},
                           {"discovery", to_string(kinds->discovery)},
                           {"liveliness", to_string(kinds->liveliness)}};
  for (const auto& [name, topic] : participant.clear_topics)
    out["clear_topics"].push_back({{"topic", name},
                                   {"type", topic.type},
                                   {"published", topic.is_written},
                                   {"subscribed", topic.is_read}});
  return out;
}

Json to_json(const rtps::HandshakeFlow& flow) {
  Json out = Json::object();
  for (const auto step :
       {rtps::HandshakeStep::auth_request, rtps::HandshakeStep::request, rtps::HandshakeStep::reply,
        rtps::HandshakeStep::final, rtps::HandshakeStep::keys})
    out[std::string(to_string(step))] = flow.at(step).count;
  return out;
}

Json to_json(const rtps::Meeting& meeting, const rtps::Observer& observer) {
  return {{"a", meeting.a.to_string()},
          {"b", meeting.b.to_string()},
          {"state", to_string(meeting.state)},
          {"milliseconds", meeting.took ? Json(milliseconds(*meeting.took)) : Json(nullptr)},
          {"a_to_b", to_json(observer.flow(meeting.a, meeting.b))},
          {"b_to_a", to_json(observer.flow(meeting.b, meeting.a))}};
}

// ---- the command

struct Watched {
  rtps::Observer observer{names_in};
  std::uint64_t cut = 0;  ///< frames
};

Status watch(Capture& capture, int seconds, bool is_live, Watched& out) {
  if (!rtps::Frames::knows(capture.link()))
    return fail(Code::capture_unreadable, {.expected = "Ethernet, loopback or Linux's \"any\"",
                                           .found = "link type " + std::to_string(capture.link())});
  rtps::Frames frames;
  Progress progress("seconds of listening", is_live ? static_cast<std::size_t>(seconds) : 0);
  const auto take = [&](const Frame& frame) {
    out.cut += frame.is_whole ? 0 : 1;
    if (const auto datagram = frames.read(capture.link(), frame.octets))
      out.observer.on_datagram(datagram->payload, {datagram->from, datagram->port, frame.at});
  };
  if (!is_live) {
    // Frames read before the file breaks off still count.
    const auto status = capture.each({}, take);
    out.cut += status ? 0 : 1;
    return out.observer.datagrams() ? Status() : status;
  }
  for (int i = 0; i < seconds && check_not_interrupted(); ++i, progress.step())
    DDSSEC_RETURN_IF_ERROR(capture.each(std::chrono::seconds(1), take));
  return {};
}

Report report_of(const Watched& watched, const std::string& source) {
  const auto& observer = watched.observer;
  const auto seconds =
      std::chrono::duration<double>(observer.datagrams().last - observer.datagrams().first).count();
  Report out;
  out.result = {{"source", source},
                {"seconds", seconds},
                {"datagrams", observer.datagrams().count},
                {"rtps_messages", observer.rtps_messages()},
                {"participants", Json::array()},
                {"pairs", Json::array()}};
  out.text =
      fmt::format("{}: {} RTPS messages of {} in {:.1f} s\n", source, observer.rtps_messages(),
                  counted(observer.participants().size(), "participant"), seconds);
  for (const auto& [prefix, participant] : observer.participants()) {
    out.text += '\n' + text_of(prefix, participant);
    out.result["participants"].push_back(to_json(prefix, participant));
  }
  if (observer.left_out() > 0)
    out.text += fmt::format("\n{} of further participants and topics are left out\n",
                            counted(observer.left_out(), "message"));
  const auto meetings = meetings_of(observer);
  if (!meetings.empty()) out.text += '\n';
  for (const auto& meeting : meetings) {
    out.text += text_of(meeting, observer);
    out.result["pairs"].push_back(to_json(meeting, observer));
    if (meeting.finding) out.findings.push_back(*meeting.finding);
    if (meeting.state == MeetingState::apart) out.exit = Exit::no;
  }
  if (auto finding = all_in_different_domains(observer))
    out.findings.push_back(*std::move(finding));
  std::ranges::move(leaks_of(observer), std::back_inserter(out.findings));
  if (watched.cut > 0)
    out.findings.push_back(
        {Rule::CAP030, fmt::format("{} are cut", counted(watched.cut, "packet"))});
  for (auto& finding : out.findings) finding.document = source;
  return out;
}

Result<Report> inspect(const Arguments& arguments, const Context&) {
  const bool is_live = arguments.has("--listen");
  const auto file = arguments.text("FILE");
  if (is_live == !file.empty())
    return fail(Code::usage,
                {.expected = "a FILE or --listen", .found = is_live ? "both" : "none"});
  const auto source = is_live ? arguments.text("--listen") : file;
  DDSSEC_ASSIGN_OR_RETURN(const int seconds, arguments.number("--for", 1, kLongest));
  DDSSEC_ASSIGN_OR_RETURN(auto capture, is_live ? Capture::listen(source) : Capture::open(source));
  const auto saved = arguments.text("--save");
  if (!saved.empty()) DDSSEC_RETURN_IF_ERROR(capture.save_to(saved));
  Watched watched;
  if (auto status = watch(capture, seconds, is_live, watched); !status)
    return std::unexpected(status.error().in(source));
  auto report = report_of(watched, source);
  if (!saved.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(auto saved_file, capture.saved());
    report.files_written.push_back(std::move(saved_file));
  }
  return report;
}

}  // namespace

std::vector<Command> inspect_commands() {
  return {{.group = "",
           .name = "inspect",
           .summary = "Says how far participants on a network get with each other; exit 1: some do "
                      "not talk.",
           .positionals = {{.name = "FILE",
                            .summary = "a capture by tcpdump or Wireshark (- is standard input)",
                            .optional = true}},
           .options = {{"--listen", "IFACE", "listen on this interface instead"},
                       {"--for", "SECONDS", "how long", "10"},
                       {"--save", "FILE", "keep what was heard as a capture"}},
           .examples = {"ddssec inspect capture.pcapng", "ddssec inspect --listen eth0 --for 30"},
           .run = inspect}};
}

}  // namespace ddssec::cli
