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

// ---- the result

struct Names {
  std::string subject, issuer;

  static constexpr auto fields() {
    return std::tuple(field("subject", &Names::subject), field("issuer", &Names::issuer));
  }
};

struct Protection {
  ProtectionKind rtps, discovery, liveliness;

  static constexpr auto fields() {
    using Self = Protection;
    return std::tuple(field("rtps", &Self::rtps), field("discovery", &Self::discovery),
                      field("liveliness", &Self::liveliness));
  }
};

struct ClearTopic {
  std::string topic, type;
  bool published, subscribed;

  static constexpr auto fields() {
    using Self = ClearTopic;
    return std::tuple(field("topic", &Self::topic), field("type", &Self::type),
                      field("published", &Self::published), field("subscribed", &Self::subscribed));
  }
};

struct Seen {
  static constexpr std::string_view kDef = "observed participant";
  std::string guid_prefix, name, vendor;
  std::optional<unsigned> domain;
  std::vector<std::string> addresses;
  bool announced, secured;
  std::optional<Names> certificate;
  std::optional<Protection> protection;
  std::uint64_t messages, protected_messages, protected_submessages;
  std::vector<std::string> kinds;
  std::uint64_t clear_samples, encrypted_payloads;
  std::vector<ClearTopic> clear_topics;
  bool left;
  std::string issuer;  ///< also if only a hash of the CA's name was seen

  static Seen of(const GuidPrefix& prefix, const rtps::ObservedParticipant& participant);

  static constexpr auto fields() {
    return std::tuple(
        field("guid_prefix", &Seen::guid_prefix, {.def = "guid prefix"}),
        field("name", &Seen::name), field("vendor", &Seen::vendor),
        field("domain", &Seen::domain, {"null: not known"}), field("addresses", &Seen::addresses),
        field("announced", &Seen::announced), field("secured", &Seen::secured),
        field("certificate", &Seen::certificate, {"null: not seen"}),
        field("protection", &Seen::protection, {"null: not said"}),
        field("messages", &Seen::messages), field("protected_messages", &Seen::protected_messages),
        field("protected_submessages", &Seen::protected_submessages), field("kinds", &Seen::kinds),
        field("clear_samples", &Seen::clear_samples),
        field("encrypted_payloads", &Seen::encrypted_payloads),
        field("clear_topics", &Seen::clear_topics), field("left", &Seen::left));
  }
  std::string text() const {
    auto out =
        fmt::format("{}\n  {} at {}, {}GUID prefix {}\n", name, vendor, fmt::join(addresses, ", "),
                    domain ? fmt::format("domain {}, ", *domain) : "", guid_prefix);
    if (!announced) return out + "  did not announce itself\n";
    out += fmt::format("  identity     {}\n", !secured         ? "none: it is not secured"
                                              : issuer.empty() ? "not said before the handshake"
                                                               : "issued by " + issuer);
    if (secured && protection)
      out += fmt::format("  protection   rtps {}, discovery {}, liveliness {}\n",
                         to_string(protection->rtps), to_string(protection->discovery),
                         to_string(protection->liveliness));
    out += fmt::format(
        "  sent         {} messages, {} protected whole, {} submessages protected{}{}\n", messages,
        protected_messages, protected_submessages, kinds.empty() ? "" : ", ",
        fmt::join(kinds, ", "));
    if (clear_samples + clear_topics.size() > 0)
      out += fmt::format("  in the clear {}, {}\n", counted(clear_samples, "sample"),
                         counted(clear_topics.size(), "topic"));
    return out;
  }
};

Seen Seen::of(const GuidPrefix& prefix, const rtps::ObservedParticipant& participant) {
  Seen out{.guid_prefix = prefix.to_string(),
           .name = name_of(prefix, participant),
           .vendor = name_of(participant.vendor),
           .domain = {},
           .addresses = {participant.addresses.begin(), participant.addresses.end()},
           .announced = participant.data.has_value(),
           .secured = participant.is_secured(),
           .certificate = {},
           .protection = {},
           .messages = participant.messages.count,
           .protected_messages = participant.protected_messages,
           .protected_submessages = participant.protected_submessages,
           .kinds = kinds_of(participant),
           .clear_samples = participant.clear_samples,
           .encrypted_payloads = participant.encrypted_payloads,
           .clear_topics = {},
           .left = participant.left,
           .issuer = issuer_of(participant)};
  if (participant.domain >= 0) out.domain = static_cast<unsigned>(participant.domain);
  if (const auto& names = participant.certificate)
    out.certificate = Names{names->subject, names->issuer};
  if (participant.data && participant.data->security_info)
    if (const auto kinds = spi::attributes_in(*participant.data->security_info))
      out.protection = Protection{kinds->rtps, kinds->discovery, kinds->liveliness};
  for (const auto& [name, topic] : participant.clear_topics)
    out.clear_topics.push_back({name, topic.type, topic.is_written, topic.is_read});
  return out;
}

/// How many messages of each step went one way.
struct Flow {
  static constexpr std::string_view kDef = "handshake flow";
  std::uint64_t auth_request, request, reply, final, keys;

  static Flow of(const rtps::HandshakeFlow& flow) {
    using Step = rtps::HandshakeStep;
    const auto count = [&](Step step) { return flow.at(step).count; };
    return {count(Step::auth_request), count(Step::request), count(Step::reply), count(Step::final),
            count(Step::keys)};
  }
  static constexpr auto fields() {
    return std::tuple(field("auth_request", &Flow::auth_request), field("request", &Flow::request),
                      field("reply", &Flow::reply), field("final", &Flow::final),
                      field("keys", &Flow::keys));
  }
};

struct Pair {
  std::string a, b;
  MeetingState state;
  std::optional<double> milliseconds;
  Flow a_to_b, b_to_a;
  std::string names;  ///< of both

  static Pair of(const rtps::Meeting& meeting, const rtps::Observer& observer);

  static constexpr auto fields() {
    return std::tuple(
        field("a", &Pair::a, {.def = "guid prefix"}), field("b", &Pair::b, {.def = "guid prefix"}),
        field("state", &Pair::state, {.words = "unsecured|apart|under way|authenticated"}),
        field("milliseconds", &Pair::milliseconds, {"null: not authenticated, or not seen"}),
        field("a_to_b", &Pair::a_to_b, {"messages of each step of the handshake"}),
        field("b_to_a", &Pair::b_to_a, {.note = "the same", .same = true}));
  }
  std::string text() const {
    return fmt::format("{}: {}{}\n", names,
                       state == MeetingState::apart ? "they do NOT talk" : to_string(state),
                       milliseconds ? fmt::format(" within {:.0f} ms", *milliseconds) : "");
  }
};

Pair Pair::of(const rtps::Meeting& meeting, const rtps::Observer& observer) {
  const auto& [a, b] = std::tie(meeting.a, meeting.b);
  const auto name = [&](const GuidPrefix& prefix) {
    return name_of(prefix, observer.participants().at(prefix));
  };
  using Milliseconds = std::chrono::duration<double, std::milli>;
  return {.a = a.to_string(),
          .b = b.to_string(),
          .state = meeting.state,
          .milliseconds =
              meeting.took ? std::optional(Milliseconds(*meeting.took).count()) : std::nullopt,
          .a_to_b = Flow::of(observer.flow(a, b)),
          .b_to_a = Flow::of(observer.flow(b, a)),
          .names = fmt::format("{} and {}", name(a), name(b))};
}

struct Inspection {
  std::string source;
  double seconds;
  std::uint64_t datagrams, rtps_messages;
  std::vector<Seen> participants = {};
  std::vector<Pair> pairs = {};
  std::uint64_t left_out;

  static constexpr auto fields() {
    using Self = Inspection;
    return std::tuple(field("source", &Self::source), field("seconds", &Self::seconds),
                      field("datagrams", &Self::datagrams),
                      field("rtps_messages", &Self::rtps_messages),
                      field("participants", &Self::participants, {.apart = true}),
                      field("pairs", &Self::pairs, {.apart = true}));
  }
  std::string text() const {
    auto out = fmt::format("{}: {} RTPS messages of {} in {:.1f} s\n", source, rtps_messages,
                           counted(participants.size(), "participant"), seconds);
    for (const auto& one : participants) out += '\n' + one.text();
    if (left_out > 0)
      out += fmt::format("\n{} of further participants and topics are left out\n",
                         counted(left_out, "message"));
    if (!pairs.empty()) out += '\n';
    for (const auto& one : pairs) out += one.text();
    return out;
  }
};

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

Answer<Inspection> answer_of(const Watched& watched, const std::string& source) {
  const auto& observer = watched.observer;
  const auto& datagrams = observer.datagrams();
  Answer<Inspection> answer{
      {.source = source,
       .seconds = std::chrono::duration<double>(datagrams.last - datagrams.first).count(),
       .datagrams = datagrams.count,
       .rtps_messages = observer.rtps_messages(),
       .left_out = observer.left_out()}};
  auto& [result, out, has_result] = answer;
  for (const auto& [prefix, participant] : observer.participants())
    result.participants.push_back(Seen::of(prefix, participant));
  for (const auto& meeting : meetings_of(observer)) {
    result.pairs.push_back(Pair::of(meeting, observer));
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
  return answer;
}

Result<Answer<Inspection>> inspect(const Arguments& arguments, const Context&) {
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
  auto answer = answer_of(watched, source);
  if (!saved.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(auto saved_file, capture.saved());
    answer.report.files_written.push_back(std::move(saved_file));
  }
  return answer;
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
