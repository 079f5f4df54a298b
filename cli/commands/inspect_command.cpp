// inspect: shows the network traffic, and where participants that should communicate get stuck.
#include <algorithm>

#include <fmt/format.h>

#include "cli/commands/groups.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/frame/progress.hpp"
#include "cli/inputs/capture.hpp"
#include "pki/certificate.hpp"
#include "rtps/observer/frames.hpp"
#include "rtps/observer/meetings.hpp"
#include "wire/vendor_name.hpp"

namespace ddssec::cli {
namespace {

using rtps::MeetingState;

constexpr int kMax = 86'400;

}  // namespace

template <>
struct FieldsOf<rtps::CertificateNames> {
  using T = rtps::CertificateNames;
  static constexpr auto fields() { return std::tuple(field<&T::subject>(), field<&T::issuer>()); }
};

namespace {

// CryptoTransformKind (DDS-Security 1.2, clause 10.5.2.1.1), whatever its key revision.
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

// ---- text output

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
    out += fmt::format("  in the clear {}, {}\n", count_text(participant.clear_samples, "sample"),
                       count_text(participant.clear_topics.size(), "topic"));
  return out;
}

std::string text_of(const rtps::ObservedMeeting& meeting, const rtps::Observer& observer) {
  const auto name = [&](const GuidPrefix& prefix) {
    return name_of(prefix, observer.participants().at(prefix));
  };
  auto out = fmt::format(
      "{} and {}: {}", name(meeting.a), name(meeting.b),
      meeting.state == MeetingState::apart ? "they do NOT talk" : to_string(meeting.state));
  if (meeting.took) out += fmt::format(" within {:.0f} ms", milliseconds(*meeting.took));
  return out + '\n';
}

// ---- JSON output

struct Protection {
  ProtectionKind rtps, discovery, liveliness;

  static constexpr auto fields() {
    using T = Protection;
    return std::tuple(field<&T::rtps>(), field<&T::discovery>(), field<&T::liveliness>());
  }
};

std::optional<Protection> protection_of(const rtps::ObservedParticipant& participant) {
  if (!participant.data) return std::nullopt;
  const auto kinds =
      spi::attributes_in(participant.data->security_info.value_or(spi::SecurityInfo{}));
  if (!kinds) return std::nullopt;
  return Protection{kinds->rtps, kinds->discovery, kinds->liveliness};
}

struct ClearTopic {
  const std::string* topic;
  const rtps::ObservedTopic* by;

  static constexpr auto fields() {
    using T = ClearTopic;
    using By = rtps::ObservedTopic;
    return std::tuple(computed<T>("topic", [](const T& one) { return *one.topic; }),
                      field("type", &T::by, &By::type), field("published", &T::by, &By::is_written),
                      field("subscribed", &T::by, &By::is_read));
  }
};

struct ListedParticipant {
  static constexpr std::string_view kDef = "observed participant";
  const GuidPrefix* prefix;
  const rtps::ObservedParticipant* by;

  std::string name() const { return name_of(*prefix, *by); }
  std::vector<ClearTopic> clear_topics() const {
    std::vector<ClearTopic> out;
    for (const auto& [name, topic] : by->clear_topics) out.push_back({&name, &topic});
    return out;
  }
  static constexpr auto fields() {
    using T = ListedParticipant;
    using By = rtps::ObservedParticipant;
    return std::tuple(
        field("guid_prefix", &T::prefix, &GuidPrefix::to_string, {.def = "guid prefix"}),
        field<&T::name>(),
        computed<T>("vendor", [](const T& one) { return std::string(name_of(one.by->vendor)); }),
        computed<T>("domain",
                    [](const T& one) {
                      const auto domain = one.by->domain;
                      return domain < 0 ? std::nullopt : std::optional(unsigned(domain));
                    },
                    {"null: not known"}),
        computed<T>("addresses",
                    [](const T& one) {
                      const auto& all = one.by->addresses;
                      return std::vector<std::string>(all.begin(), all.end());
                    }),
        computed<T>("announced", [](const T& one) { return one.by->data.has_value(); }),
        field("secured", &T::by, &By::is_secured),
        field("certificate", &T::by, &By::certificate, {"null: not seen"}),
        computed<T>("protection", [](const T& one) { return protection_of(*one.by); },
                    {"null: not said"}),
        computed<T>("messages", [](const T& one) { return one.by->messages.count; }),
        field("protected_messages", &T::by, &By::protected_messages),
        field("protected_submessages", &T::by, &By::protected_submessages),
        computed<T>("kinds", [](const T& one) { return kinds_of(*one.by); }),
        field("clear_samples", &T::by, &By::clear_samples),
        field("encrypted_payloads", &T::by, &By::encrypted_payloads), field<&T::clear_topics>(),
        field("left", &T::by, &By::has_left));
  }
};

template <rtps::HandshakeStep step>
std::uint64_t count_of(const rtps::HandshakeFlow& flow) {
  return flow.at(step).count;
}

}  // namespace

template <>
struct FieldsOf<rtps::HandshakeFlow> {
  using T = rtps::HandshakeFlow;
  using Step = rtps::HandshakeStep;
  static constexpr std::string_view kDef = "handshake flow";
  static constexpr auto fields() {
    return std::tuple(computed<T>("auth_request", count_of<Step::auth_request>),
                      computed<T>("request", count_of<Step::request>),
                      computed<T>("reply", count_of<Step::reply>),
                      computed<T>("final", count_of<Step::final>),
                      computed<T>("keys", count_of<Step::keys>));
  }
};

namespace {

struct Pair {
  rtps::ObservedMeeting meeting;
  const rtps::Observer* observer;

  static constexpr auto fields() {
    using T = Pair;
    return std::tuple(
        computed<T>("a", [](const T& one) { return one.meeting.a.to_string(); },
                    {.def = "guid prefix"}),
        computed<T>("b", [](const T& one) { return one.meeting.b.to_string(); },
                    {.def = "guid prefix"}),
        field("state", &T::meeting, &rtps::ObservedMeeting::state,
              {.words = "unsecured|apart|under way|authenticated"}),
        computed<T>("milliseconds",
                    [](const T& one) {
                      const auto took = one.meeting.took;
                      return took ? std::optional(milliseconds(*took)) : std::nullopt;
                    },
                    {"null: not authenticated, or not seen"}),
        computed<T>("a_to_b",
                    [](const T& one) { return one.observer->flow(one.meeting.a, one.meeting.b); },
                    {"messages of each step of the handshake"}),
        computed<T>("b_to_a",
                    [](const T& one) { return one.observer->flow(one.meeting.b, one.meeting.a); },
                    {.note = "the same", .has_same_members = true}));
  }
};

// ---- the command

struct Observation {
  rtps::Observer observer{names_in};
  std::uint64_t cut = 0;  // frames that are cut short
};

Status watch(Capture& capture, int seconds, bool is_live, Observation& out) {
  if (!rtps::Frames::knows(capture.link()))
    return fail(Code::capture_unreadable, {.expected = "Ethernet, loopback or Linux's \"any\"",
                                           .found = "link type " + std::to_string(capture.link())});
  rtps::Frames frames;
  Progress progress("seconds of listening", is_live ? static_cast<std::size_t>(seconds) : 0);
  const auto take = [&](const CapturedFrame& frame) {
    out.cut += frame.is_whole ? 0 : 1;
    if (const auto datagram = frames.read(capture.link(), frame.octets))
      out.observer.on_datagram(datagram->payload, {datagram->from, datagram->port, frame.at});
  };
  if (!is_live) {
    // The frames before the place where the file breaks off still count.
    const auto status = capture.each({}, take);
    out.cut += status ? 0 : 1;
    return out.observer.datagrams() ? Status() : status;
  }
  for (int i = 0; i < seconds && check_not_interrupted(); ++i, progress.step())
    DDSSEC_RETURN_IF_ERROR(capture.each(std::chrono::seconds(1), take));
  return {};
}

struct Inspection {
  std::string source;
  Observation watched;

  double seconds() const {
    const auto& datagrams = watched.observer.datagrams();
    return std::chrono::duration<double>(datagrams.last - datagrams.first).count();
  }
  std::vector<ListedParticipant> participants() const {
    std::vector<ListedParticipant> out;
    for (const auto& [prefix, participant] : watched.observer.participants())
      out.push_back({&prefix, &participant});
    return out;
  }
  std::vector<Pair> pairs() const {
    std::vector<Pair> out;
    for (auto& meeting : meetings_of(watched.observer))
      out.push_back({std::move(meeting), &watched.observer});
    return out;
  }
  static constexpr auto fields() {
    using T = Inspection;
    return std::tuple(
        field<&T::source>(), field<&T::seconds>(),
        computed<T>("datagrams",
                    [](const T& one) { return one.watched.observer.datagrams().count; }),
        computed<T>("rtps_messages",
                    [](const T& one) { return one.watched.observer.rtps_messages(); }),
        field<&T::participants>({.has_own_row = true}), field<&T::pairs>({.has_own_row = true}));
  }
  std::string text() const {
    const auto& observer = watched.observer;
    auto out =
        fmt::format("{}: {} RTPS messages of {} in {:.1f} s\n", source, observer.rtps_messages(),
                    count_text(observer.participants().size(), "participant"), seconds());
    for (const auto& [prefix, participant] : observer.participants())
      out += '\n' + text_of(prefix, participant);
    if (observer.left_out() > 0)
      out += fmt::format("\n{} of further participants and topics are left out\n",
                         count_text(observer.left_out(), "message"));
    const auto meetings = pairs();
    if (!meetings.empty()) out += '\n';
    for (const auto& one : meetings) out += text_of(one.meeting, observer);
    return out;
  }
};

void add_findings(const Inspection& result, Report& out) {
  const auto& observer = result.watched.observer;
  for (const auto& [meeting, ignored] : result.pairs()) {
    if (meeting.finding) out.findings.push_back(*meeting.finding);
    if (meeting.state == MeetingState::apart) out.exit = Exit::no;
  }
  if (auto finding = all_in_different_domains(observer))
    out.findings.push_back(*std::move(finding));
  std::ranges::move(leaks_of(observer), std::back_inserter(out.findings));
  if (result.watched.cut > 0)
    out.findings.push_back(
        {Rule::CAP030, fmt::format("{} are cut", count_text(result.watched.cut, "packet"))});
  for (auto& finding : out.findings) finding.document = result.source;
}

Result<Answer<Inspection>> inspect(const Arguments& arguments, const Context&) {
  const bool is_live = arguments.has("--listen");
  const auto file = arguments.text("FILE");
  if (is_live == !file.empty())
    return fail(Code::usage,
                {.expected = "a FILE or --listen", .found = is_live ? "both" : "none"});
  const auto source = is_live ? arguments.text("--listen") : file;
  DDSSEC_ASSIGN_OR_RETURN(const int seconds, arguments.number("--for", 1, kMax));
  DDSSEC_ASSIGN_OR_RETURN(auto capture, is_live ? Capture::listen(source) : Capture::open(source));
  const auto saved = arguments.text("--save");
  if (!saved.empty()) DDSSEC_RETURN_IF_ERROR(capture.save_to(saved));
  Answer<Inspection> answer{{source, {}}};
  DDSSEC_RETURN_IF_ERROR(
      with_default_document(watch(capture, seconds, is_live, answer.result.watched), source));
  add_findings(answer.result, answer.report);
  if (!saved.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(auto saved_file, capture.saved());
    answer.report.files_written.push_back(std::move(saved_file));
  }
  return answer;
}

}  // namespace

std::vector<Command> inspect_commands() {
  return {
      {.group = "",
       .name = "inspect",
       .summary = "Says how far participants on a network get with each other; exit 1: some do "
                  "not talk.",
       .positionals = {{.name = "FILE",
                        .summary = "a capture by tcpdump or Wireshark (- is standard input)",
                        .optional = true}},
       .options = {{"--listen", "IFACE", "listen on this interface instead"},
                   {"--for", "SECONDS",
                    "how long; a Cyclone DDS participant announces itself every 8 seconds", "10"},
                   {"--save", "FILE", "keep what was heard as a capture"}},
       .examples = {"ddssec inspect capture.pcapng", "ddssec inspect --listen eth0 --for 30"},
       .run = inspect}};
}

}  // namespace ddssec::cli
