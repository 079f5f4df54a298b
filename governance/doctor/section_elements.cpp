#include "governance/doctor/section_elements.hpp"

#include <algorithm>
#include <span>

namespace ddssec::governance::doctor {
namespace {

// What Cyclone DDS 0.10.2 and 0.10.5 know, which does not differ.
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

struct Section {
  std::string_view name;
  std::span<const std::string_view> elements;
};
constexpr Section kSections[] = {
    {"compatibility", kCompatibility},
    {"discovery", kDiscovery},
    {"general", kGeneral},
    {"internal", kInternal},
    {"partitioning", kPartitioning},
    {"sharedmemory", kSharedMemory},
    {"sizing", kSizing},
    {"ssl", kSsl},
    {"tcp", kTcp},
    {"threads", kThreads},
    {"tracing", kTracing},
    {"unsupported", kInternal},
};

}  // namespace

bool is_section(std::string_view name) {
  return std::ranges::find(kSections, name, &Section::name) != std::end(kSections);
}

bool is_known_inside(std::string_view section, std::string_view element) {
  const auto* const found = std::ranges::find(kSections, section, &Section::name);
  return found == std::end(kSections) ||
         std::ranges::find(found->elements, element) != found->elements.end();
}

}  // namespace ddssec::governance::doctor
