#include "cli/explain/log_sentences.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>

#include "base/text.hpp"

namespace ddssec::cli {
namespace {

constexpr std::string_view kGap = "...";

// docs/sentences-of-cyclone-dds.md has the same rows, and tests/cli/sentences_test.py compares
// them.
constexpr std::array kSentences = {
    LogSentence{"Could not load Authentication library: ...: cannot open shared object file",
                "the library of the <Library> element is not found",
                "the path in the line; LD_LIBRARY_PATH; ddssec doctor FOLDER"},
    LogSentence{"Could not load Access Control library: ...: cannot open shared object file",
                "the library of the <Library> element is not found",
                "the path in the line; LD_LIBRARY_PATH; ddssec doctor FOLDER"},
    LogSentence{"Could not load Cryptographic library: ...: cannot open shared object file",
                "the library of the <Library> element is not found",
                "the path in the line; LD_LIBRARY_PATH; ddssec doctor FOLDER"},
    LogSentence{"Error occurred while validating local permission: ...",
                "this participant's own certificate, key or identity CA is refused: expired, "
                "wrong key, damaged file; \"permission\" is a slip of Cyclone DDS",
                "ddssec doctor FOLDER"},
    LogSentence{"Error occurred while validating local permissions: ...",
                "this participant's own governance or permissions are refused: signed by "
                "another CA, changed after signing, expired, or no rule for this domain",
                "ddssec doctor FOLDER"},
    LogSentence{"It is not allowed to create participant: Could not find domain ... in governance",
                "no <domain_rule> covers the domain; the stock plugins say it so",
                "ddssec governance show FILE"},
    LogSentence{"Not Allowed By Security",
                "the permissions do not allow this participant to write or read that topic; "
                "ddssec's own line names the rule, the stock plugins are silent",
                "ddssec can FOLDER publish TOPIC"},
    LogSentence{"Begin handshake reply failed: ...",
                "this side refused the other's first message, mostly its certificate: another "
                "identity CA, expired, revoked",
                "ddssec check OWN OTHER"},
    LogSentence{"Process handshake failed: ...",
                "this side refused a later message; \"Failed to finalize digest context\" is "
                "the stock plugins' sentence for a wrong signature: the other one has another "
                "participant's key",
                "ddssec check OWN OTHER; on the other side ddssec doctor FOLDER"},
    LogSentence{"Failed to finalize digest context",
                "the stock plugins' sentence for a wrong signature: the other one has another "
                "participant's key",
                "on the other side ddssec doctor FOLDER"},
    LogSentence{"Could not get remote participant ... permissions from plugin: ...",
                "the certificate is good and the permissions document is not, mostly since "
                "another permissions CA signed it",
                "ddssec check OWN OTHER"},
    LogSentence{"match remote_participant ... security_attributes mismatch: ...",
                "the two governance documents protect the whole domain differently: discovery, "
                "liveliness or RTPS messages; \"not allowed\" follows",
                "ddssec governance diff OWN OTHER"},
    LogSentence{"Remote secure participant ... not allowed",
                "the two do not match now: after a \"mismatch\" line it stays so; alone, "
                "at the start, it is mostly harmless: the other one was still authenticating; "
                "without a line of ddssec beside it, the log of the other side has the reason",
                "the line before it; ddssec check OWN OTHER"},
    LogSentence{"match_remote_writer ... security_attributes mismatch: ...",
                "the participants authenticate each other, and protect this topic differently: "
                "there is no match "
                "for it",
                "ddssec governance diff OWN OTHER"},
    LogSentence{"match_remote_reader ... security_attributes mismatch: ...",
                "the participants authenticate each other, and protect this topic differently: "
                "there is no match "
                "for it",
                "ddssec governance diff OWN OTHER"},
    LogSentence{"Failed to register remote writer ... with reader ...",
                "access control or cryptography refused this match, for example because the "
                "permissions no longer allow the topic",
                "ddssec's own line before it; ddssec check OWN OTHER"},
    LogSentence{"Failed to register remote reader ... with writer ...",
                "access control or cryptography refused this match, for example because the "
                "permissions no longer allow the topic",
                "ddssec's own line before it; ddssec check OWN OTHER"},
    LogSentence{"failed to match in ...",
                "from ddsperf: no endpoints of another ddsperf were found; the line \"new\" "
                "before it comes before security, so it does not mean that keys were exchanged",
                "plugins_in_use in both logs; ddssec check OWN OTHER"},
    LogSentence{"ddsi_udp_conn_write to udp/... failed with retcode -1",
                "not security: the other one announced an address that no route leads to",
                "ip route get ADDRESS"},
    LogSentence{"could not find all security files",
                "the node was started without --ros-args --enclave NAME and asked for the root "
                "enclave, which the keystore does not have; or the enclave lacks a file",
                "ddssec doctor ENCLAVE_FOLDER --ros", "ROS 2"},
    LogSentence{
        "failed to initialize rcl: error not set",
        "ROS_SECURITY_KEYSTORE is not set where the node starts; in another line, such as "
        "'error not set, at ...', the words do not name a cause: ddssec's line above it has the "
        "cause",
        "ddssec doctor ENCLAVE_FOLDER --ros, in the terminal in which the node starts", "ROS 2"},
    LogSentence{"SECURITY ERROR: directory ... does not exist",
                "the keystore has no enclave of the name after --enclave; or ROS_SECURITY_KEYSTORE "
                "is a relative path or names another folder",
                "ddssec keystore list KEYSTORE; ddssec doctor ENCLAVE_FOLDER --ros", "ROS 2"},
    LogSentence{"failed to create DDS participant",
                "follows after the participant was refused: certificate, permissions, domain or "
                "plugins; the line says no more",
                "the first line with \"ddssec error\" above it; ddssec doctor ENCLAVE_FOLDER --ros",
                "ROS 2"},
    LogSentence{"rmw handle is invalid",
                "follows after the node did not start; the line says no more",
                "the first line with \"ddssec error\" above it; ddssec doctor ENCLAVE_FOLDER --ros",
                "ROS 2"},
    LogSentence{"failed to create topic [...]",
                "a topic was refused; of a topic of every node, such as "
                "rr/talker/get_parametersReply: the node probably has the enclave of another node "
                "(--enclave), or permissions without --node-defaults",
                "ddssec's own line before it; ddssec doctor ENCLAVE_FOLDER --ros", "ROS 2"},
    LogSentence{"invalid allocator",
                "follows after a topic was refused: see \"failed to create topic\"",
                "ddssec's own line before it; ddssec doctor ENCLAVE_FOLDER --ros", "ROS 2"},
};

// Removes the gaps at the end, because they match anything.
std::string_view without_end(std::string_view sentence) {
  while (sentence.ends_with(kGap) || sentence.ends_with(' '))
    sentence.remove_suffix(sentence.ends_with(kGap) ? kGap.size() : 1);
  return sentence;
}

// True if everything between the gaps is in the line, in this order.
bool is_in(std::string_view sentence, std::string_view line) {
  auto rest = without_end(sentence);
  while (true) {
    const auto gap = rest.find(kGap);
    const auto piece = rest.substr(0, gap);
    const auto at = line.find(piece);
    if (at == line.npos) return false;
    if (gap == rest.npos) return true;
    line.remove_prefix(at + piece.size());
    rest.remove_prefix(gap + kGap.size());
  }
}

}  // namespace

std::span<const LogSentence> log_sentences() { return kSentences; }

std::vector<LogSentence> log_sentences_like(std::string_view text) {
  constexpr std::size_t kMinSentencePart = 4;
  std::vector<LogSentence> out;
  if (text.size() < kMinSentencePart) return out;
  const auto wanted = ascii_upper(text);
  std::ranges::copy_if(kSentences, std::back_inserter(out), [&](const LogSentence& row) {
    const auto sentence = ascii_upper(row.sentence);
    return sentence.contains(wanted) || is_in(sentence, wanted);
  });
  return out;
}

}  // namespace ddssec::cli
