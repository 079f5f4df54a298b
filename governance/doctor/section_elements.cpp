#include "governance/doctor/section_elements.hpp"

#include <algorithm>
#include <span>
#include <string>

namespace ddssec::governance::doctor {
namespace {

// The elements that Cyclone DDS 0.10.2 and 0.10.5 know; both versions know the same.
constexpr std::string_view kGeneral[] = {"allowmulticast",
                                         "dontroute",
                                         "enablemulticastloopback",
                                         "entityautonaming",
                                         "externalnetworkaddress",
                                         "externalnetworkmask",
                                         "fragmentsize",
                                         "interfaces",
                                         "maxmessagesize",
                                         "maxrexmitmessagesize",
                                         "multicastrecvnetworkinterfaceaddresses",
                                         "multicasttimetolive",
                                         "networkinterfaceaddress",
                                         "prefermulticast",
                                         "redundantnetworking",
                                         "transport",
                                         "useipv6"};
constexpr std::string_view kPartitioning[] = {"ignoredpartitions", "networkpartitions",
                                              "partitionmappings"};
constexpr std::string_view kThreads[] = {"thread"};
constexpr std::string_view kSizing[] = {"receivebufferchunksize", "receivebuffersize"};
constexpr std::string_view kCompatibility[] = {"assumertihaspmdendpoints",
                                               "explicitlypublishqossettodefault",
                                               "manysocketsmode", "standardsconformance"};
constexpr std::string_view kDiscovery[] = {"defaultmulticastaddress",
                                           "dsgraceperiod",
                                           "enabletopicdiscoveryendpoints",
                                           "externaldomainid",
                                           "leaseduration",
                                           "maxautoparticipantindex",
                                           "participantindex",
                                           "peers",
                                           "ports",
                                           "spdpinterval",
                                           "spdpmulticastaddress",
                                           "tag"};
constexpr std::string_view kTracing[] = {"appendtofile", "category",          "enablecategory",
                                         "outputfile",   "packetcapturefile", "verbosity"};
constexpr std::string_view kInternal[] = {"acceleraterexmitblocksize",
                                          "ackdelay",
                                          "assumemulticastcapable",
                                          "autoreschednackdelay",
                                          "auxiliarybandwidthlimit",
                                          "builtinendpointset",
                                          "burstsize",
                                          "controltopic",
                                          "ddsi2directmaxthreads",
                                          "defragreliablemaxsamples",
                                          "defragunreliablemaxsamples",
                                          "deliveryqueuemaxsamples",
                                          "enableexpensivechecks",
                                          "fragmentsize",
                                          "generatekeyhash",
                                          "heartbeatinterval",
                                          "lateackmode",
                                          "leaseduration",
                                          "livelinessmonitoring",
                                          "maxmessagesize",
                                          "maxparticipants",
                                          "maxqueuedrexmitbytes",
                                          "maxqueuedrexmitmessages",
                                          "maxsamplesize",
                                          "measurehbtoacklatency",
                                          "minimumsocketreceivebuffersize",
                                          "minimumsocketsendbuffersize",
                                          "monitorport",
                                          "multiplereceivethreads",
                                          "nackdelay",
                                          "preemptiveackdelay",
                                          "primaryreordermaxsamples",
                                          "prioritizeretransmit",
                                          "rediscoveryblacklistduration",
                                          "retransmitmerging",
                                          "retransmitmergingperiod",
                                          "retryonrejectbesteffort",
                                          "scheduletimerounding",
                                          "secondaryreordermaxsamples",
                                          "socketreceivebuffersize",
                                          "socketsendbuffersize",
                                          "spdpresponsemaxdelay",
                                          "squashparticipants",
                                          "synchronousdeliverylatencybound",
                                          "synchronousdeliveryprioritythreshold",
                                          "test",
                                          "unicastresponsetospdpmessages",
                                          "usemulticastifmreqn",
                                          "watermarks",
                                          "writebatch",
                                          "writerlingerduration"};
constexpr std::string_view kTcp[] = {
    "alwaysusepeeraddrforunicast", "enable", "nodelay", "port", "readtimeout", "writetimeout"};
constexpr std::string_view kSsl[] = {"certificateverification",
                                     "ciphers",
                                     "enable",
                                     "entropyfile",
                                     "keypassphrase",
                                     "keystorefile",
                                     "minimumtlsversion",
                                     "selfsignedcertificates",
                                     "verifyclient"};
constexpr std::string_view kSharedMemory[] = {"enable", "locator", "loglevel", "prefix"};

constexpr std::string_view kInterfaces[] = {"networkinterface"};
constexpr std::string_view kInterfaceAttributes[] = {
    "address",          "autodetermine",     "multicast", "name",
    "prefer_multicast", "presence_required", "priority"};
constexpr std::string_view kIgnoredPartitions[] = {"ignoredpartition"};
constexpr std::string_view kNetworkPartitions[] = {"networkpartition"};
constexpr std::string_view kPartitionMappings[] = {"partitionmapping"};
constexpr std::string_view kTopicOfPartition[] = {"dcpspartitiontopic"};
constexpr std::string_view kNetworkPartition[] = {"address", "name"};
constexpr std::string_view kPartitionMapping[] = {"dcpspartitiontopic", "networkpartition"};
constexpr std::string_view kThread[] = {"scheduling", "stacksize"};
constexpr std::string_view kScheduling[] = {"class", "priority"};
constexpr std::string_view kName[] = {"name"};
constexpr std::string_view kPeers[] = {"peer"};
constexpr std::string_view kAddress[] = {"address"};
constexpr std::string_view kPorts[] = {"base",
                                       "domaingain",
                                       "multicastdataoffset",
                                       "multicastmetaoffset",
                                       "participantgain",
                                       "unicastdataoffset",
                                       "unicastmetaoffset"};
constexpr std::string_view kBurstSize[] = {"maxinittransmit", "maxrexmit"};
constexpr std::string_view kControlTopic[] = {"deaf", "mute"};
constexpr std::string_view kControlTopicAttributes[] = {"enable", "initialreset"};
constexpr std::string_view kTest[] = {"xmitlossiness"};
constexpr std::string_view kWatermarks[] = {"whcadaptive", "whchigh", "whchighinit", "whclow"};
constexpr std::string_view kHeartbeat[] = {"max", "min", "minsched"};
constexpr std::string_view kLiveliness[] = {"interval", "stacktraces"};
constexpr std::string_view kRetries[] = {"maxretries"};
constexpr std::string_view kEnforce[] = {"enforce"};
constexpr std::string_view kMinMax[] = {"max", "min"};

using Names = std::span<const std::string_view>;
struct Element {
  std::string_view path;
  Names elements = {};
  Names attributes = {};
};
// Sections, and the elements in them that have elements or attributes.
constexpr Element kElements[] = {
    {"compatibility", kCompatibility},
    {"discovery", kDiscovery},
    {"discovery/peers", kPeers},
    {"discovery/peers/peer", {}, kAddress},
    {"discovery/ports", kPorts},
    {"general", kGeneral},
    {"general/interfaces", kInterfaces},
    {"general/interfaces/networkinterface", {}, kInterfaceAttributes},
    {"internal", kInternal},
    {"internal/burstsize", kBurstSize},
    {"internal/controltopic", kControlTopic, kControlTopicAttributes},
    {"internal/heartbeatinterval", {}, kHeartbeat},
    {"internal/livelinessmonitoring", {}, kLiveliness},
    {"internal/multiplereceivethreads", {}, kRetries},
    {"internal/rediscoveryblacklistduration", {}, kEnforce},
    {"internal/socketreceivebuffersize", {}, kMinMax},
    {"internal/socketsendbuffersize", {}, kMinMax},
    {"internal/test", kTest},
    {"internal/watermarks", kWatermarks},
    {"partitioning", kPartitioning},
    {"partitioning/ignoredpartitions", kIgnoredPartitions},
    {"partitioning/ignoredpartitions/ignoredpartition", {}, kTopicOfPartition},
    {"partitioning/networkpartitions", kNetworkPartitions},
    {"partitioning/networkpartitions/networkpartition", {}, kNetworkPartition},
    {"partitioning/partitionmappings", kPartitionMappings},
    {"partitioning/partitionmappings/partitionmapping", {}, kPartitionMapping},
    {"sharedmemory", kSharedMemory},
    {"sizing", kSizing},
    {"ssl", kSsl},
    {"tcp", kTcp},
    {"threads", kThreads},
    {"threads/thread", kThread, kName},
    {"threads/thread/scheduling", kScheduling},
    {"tracing", kTracing},
};
// The elements of which a list may have several.
constexpr std::string_view kRepeated[] = {"ignoredpartition",
                                          "networkinterface",
                                          "networkpartition",
                                          "partitionmapping",
                                          "peer",
                                          "thread"};

const Element* element_at(std::string_view path) {
  const auto* const found = std::ranges::find(kElements, path, &Element::path);
  return found == std::end(kElements) ? nullptr : found;
}

bool is_among(Names names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

std::string section_path(std::string_view name) {
  if (name == "unsupported") return "internal";  // its former name
  return element_at(name) == nullptr ? std::string() : std::string(name);
}

bool is_known_inside(std::string_view path, std::string_view element) {
  const auto* const found = element_at(path);
  return found != nullptr && is_among(found->elements, element);
}

std::string path_inside(std::string_view path, std::string_view element) {
  const bool has_moved =
      path == "internal" && (element == "maxmessagesize" || element == "fragmentsize");
  return std::string(has_moved ? "general" : path).append("/").append(element);
}

bool is_known_attribute(std::string_view path, std::string_view attribute) {
  const auto* const found = element_at(path);
  return found != nullptr && is_among(found->attributes, attribute);
}

bool has_elements_only(std::string_view path) {
  const auto* const found = element_at(path);
  return found != nullptr && (!found->elements.empty() || is_repeated(path));
}

bool is_repeated(std::string_view path) {
  return is_among(kRepeated, path.substr(path.rfind('/') + 1));
}

}  // namespace ddssec::governance::doctor
