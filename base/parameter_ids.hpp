// The numbers (PID_...) of the parameters in discovery, in inline QoS and in signed handshake data.
#pragma once

#include <cstdint>

namespace ddssec::pid {

/// ParameterId_t. It is a number and not an enumeration because most ids of other vendors are
/// skipped.
using Id = std::uint16_t;

// RTPS 2.5, clause 9.6.3 (parameters of discovery and inline QoS):
inline constexpr Id kPad = 0x0000;
inline constexpr Id kSentinel = 0x0001;
inline constexpr Id kParticipantLeaseDuration = 0x0002;
inline constexpr Id kTimeBasedFilter = 0x0004;
inline constexpr Id kTopicName = 0x0005;
inline constexpr Id kOwnershipStrength = 0x0006;
inline constexpr Id kTypeName = 0x0007;
inline constexpr Id kDomainId = 0x000f;
inline constexpr Id kProtocolVersion = 0x0015;
inline constexpr Id kVendorId = 0x0016;
inline constexpr Id kReliability = 0x001a;
inline constexpr Id kLiveliness = 0x001b;
inline constexpr Id kDurability = 0x001d;
inline constexpr Id kDurabilityService = 0x001e;
inline constexpr Id kOwnership = 0x001f;
inline constexpr Id kPresentation = 0x0021;
inline constexpr Id kDeadline = 0x0023;
inline constexpr Id kDestinationOrder = 0x0025;
inline constexpr Id kLatencyBudget = 0x0027;
inline constexpr Id kPartition = 0x0029;
inline constexpr Id kLifespan = 0x002b;
inline constexpr Id kUserData = 0x002c;
inline constexpr Id kGroupData = 0x002d;
inline constexpr Id kTopicData = 0x002e;
inline constexpr Id kUnicastLocator = 0x002f;
inline constexpr Id kMulticastLocator = 0x0030;
inline constexpr Id kDefaultUnicastLocator = 0x0031;
inline constexpr Id kMetatrafficUnicastLocator = 0x0032;
inline constexpr Id kMetatrafficMulticastLocator = 0x0033;
inline constexpr Id kParticipantManualLivelinessCount = 0x0034;
inline constexpr Id kContentFilterProperty = 0x0035;
inline constexpr Id kHistory = 0x0040;
inline constexpr Id kResourceLimits = 0x0041;
inline constexpr Id kExpectsInlineQos = 0x0043;
inline constexpr Id kDefaultMulticastLocator = 0x0048;
inline constexpr Id kTransportPriority = 0x0049;
inline constexpr Id kParticipantGuid = 0x0050;
inline constexpr Id kGroupGuid = 0x0052;
inline constexpr Id kContentFilterInfo = 0x0055;
inline constexpr Id kCoherentSet = 0x0056;
inline constexpr Id kBuiltinEndpointSet = 0x0058;
inline constexpr Id kPropertyList = 0x0059;
inline constexpr Id kEndpointGuid = 0x005a;
inline constexpr Id kOriginalWriterInfo = 0x0061;
inline constexpr Id kEntityName = 0x0062;
inline constexpr Id kGroupCoherentSet = 0x0063;
inline constexpr Id kGroupSeqNum = 0x0064;
inline constexpr Id kWriterGroupInfo = 0x0065;
inline constexpr Id kKeyHash = 0x0070;
inline constexpr Id kStatusInfo = 0x0071;

// DDS-XTypes 1.3, clauses 7.6.3.1 and 7.6.3.2:
inline constexpr Id kDataRepresentation = 0x0073;
inline constexpr Id kTypeConsistencyEnforcement = 0x0074;
inline constexpr Id kTypeInformation = 0x0075;

// DDS-Security 1.2, clause 7.5.1:
inline constexpr Id kIdentityToken = 0x1001;
inline constexpr Id kPermissionsToken = 0x1002;
inline constexpr Id kDataTags = 0x1003;
inline constexpr Id kEndpointSecurityInfo = 0x1004;
inline constexpr Id kParticipantSecurityInfo = 0x1005;

// DDS-Security 1.2, clauses 7.5.1.4 and 7.5.1.5 (peers of other vendors skip them):
inline constexpr Id kParticipantCiphers = 0x1012;
inline constexpr Id kEndpointCiphers = 0x1013;

/// A reader that does not know an id with this bit must not use the sample (RTPS 9.6.3.1).
inline constexpr Id kMustUnderstand = 0x4000;
/// A participant without this domain tag ignores a participant that has it (RTPS 9.6.2.2).
inline constexpr Id kDomainTag = kMustUnderstand | 0x0014;
inline constexpr Id kVendorSpecific = 0x8000;

// Specific to Cyclone DDS:
inline constexpr Id kAdlinkParticipantVersionInfo = 0x8007;
inline constexpr Id kAdlinkSubscriptionKeys = 0x800f;
inline constexpr Id kCycloneTopicGuid = 0x801b;

// Specific to ddssec:
/// The source timestamp of a DATA, as Time_t.
inline constexpr Id kSourceTime = 0x8d5e;
/// The place of a DATA's payload in shared memory (wire/memory_reference.hpp).
inline constexpr Id kMemoryReference = kVendorSpecific | 0x0d5f;
/// The type objects of an endpoint's type.
inline constexpr Id kTypeObjects = kVendorSpecific | 0x0d75;

}  // namespace ddssec::pid
