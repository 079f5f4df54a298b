// Fast DDS 2 (Debian 12) and 3 (Debian 13) under the same names, and samples of types that are
// written by hand, because Debian 12 has no Fast DDS code generator.
#ifndef DDSSEC_INTEROP_FASTDDS_API_HPP
#define DDSSEC_INTEROP_FASTDDS_API_HPP

#if DDSSEC_FASTDDS >= 3
#include <fastdds/rtps/common/SerializedPayload.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#include <fastdds/utils/md5.hpp>
#else
#include <fastdds/rtps/common/SerializedPayload.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastrtps/utils/md5.h>
#endif
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <memory>
#include <string>

namespace interop_fast {

namespace fdds = eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

#if DDSSEC_FASTDDS >= 3
namespace rtps = eprosima::fastdds::rtps;
using eprosima::fastdds::MD5;
using fdds::Duration_t;
constexpr auto kXcdr1 = eprosima::fastcdr::CdrVersion::XCDRv1;
inline bool ok(fdds::ReturnCode_t code) { return code == fdds::RETCODE_OK; }
inline std::size_t length(const Cdr& cdr) { return cdr.get_serialized_data_length(); }
inline void write_octets(Cdr& cdr, const std::uint8_t* octets, std::size_t count) {
  cdr.serialize_array(octets, count);
}
inline void set_heartbeat_period(fdds::DataWriterQos& qos, const Duration_t& period) {
  qos.reliable_writer_qos().times.heartbeat_period = period;
}
#else
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;
constexpr auto kXcdr1 = Cdr::DDS_CDR;
inline bool ok(const ReturnCode_t& code) { return code == ReturnCode_t::RETCODE_OK; }
inline bool ok(bool written) { return written; }
inline std::size_t length(const Cdr& cdr) { return cdr.getSerializedDataLength(); }
inline void write_octets(Cdr& cdr, const std::uint8_t* octets, std::size_t count) {
  cdr.serializeArray(octets, count);
}
inline void set_heartbeat_period(fdds::DataWriterQos& qos, const Duration_t& period) {
  qos.reliable_writer_qos().times.heartbeatPeriod = period;
}
#endif

/// A type in XCDR1 whose fields are written by hand.
class HandWrittenType : public fdds::TopicDataType {
 public:
  /// `size` is a first guess. Histories grow as needed.
  HandWrittenType(const char* name, std::uint32_t size, bool has_key) {
#if DDSSEC_FASTDDS >= 3
    set_name(name);
    max_serialized_type_size = size;
    is_compute_key_provided = has_key;
#else
    setName(name);
    m_typeSize = size;
    m_isGetKeyDefined = has_key;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
#endif
  }

 protected:
  virtual void write(Cdr& cdr, const void* sample) const = 0;
  virtual void read(Cdr& cdr, void* sample) const = 0;
  /// Returns at least the number of octets that write() writes, with the encapsulation header.
  virtual std::uint32_t most_octets(const void* sample) const = 0;
  /// Writes the input of the key hash's MD5, big-endian. Returns false if there is no key.
  virtual bool write_key(Cdr&, const void*) const { return false; }

 private:
  bool to_payload(const void* sample, rtps::SerializedPayload_t& payload) const {
    FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.max_size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, kXcdr1);
    note_order(cdr, payload);
    try {
      cdr.serialize_encapsulation();
      write(cdr, sample);
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    payload.length = static_cast<std::uint32_t>(length(cdr));
    return true;
  }
  bool from_payload(rtps::SerializedPayload_t& payload, void* sample) const {
    FastBuffer buffer(reinterpret_cast<char*>(payload.data), payload.length);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, kXcdr1);
    try {
      cdr.read_encapsulation();
      note_order(cdr, payload);
      read(cdr, sample);
    } catch (const eprosima::fastcdr::exception::Exception&) {
      return false;
    }
    return true;
  }
  static void note_order(const Cdr& cdr, rtps::SerializedPayload_t& payload) {
    payload.encapsulation = cdr.endianness() == Cdr::BIG_ENDIANNESS ? CDR_BE : CDR_LE;
  }
  bool hash_key(const void* sample, rtps::InstanceHandle_t& handle) const {
    std::string octets(most_octets(sample), '\0');
    FastBuffer buffer(octets.data(), octets.size());
    Cdr cdr(buffer, Cdr::BIG_ENDIANNESS, kXcdr1);
    if (!write_key(cdr, sample)) return false;
    MD5 md5;
    md5.init();
    md5.update(octets.data(), static_cast<unsigned>(length(cdr)));
    md5.finalize();
    for (unsigned i = 0; i < 16; ++i) handle.value[i] = md5.digest[i];
    return true;
  }

  // ---- calls of Fast DDS
#if DDSSEC_FASTDDS >= 3
  bool serialize(const void* const sample, rtps::SerializedPayload_t& payload,
                 fdds::DataRepresentationId_t) override {
    return to_payload(sample, payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* sample) override {
    return from_payload(payload, sample);
  }
  std::uint32_t calculate_serialized_size(const void* const sample,
                                          fdds::DataRepresentationId_t) override {
    return most_octets(sample);
  }
  bool compute_key(rtps::SerializedPayload_t& payload, rtps::InstanceHandle_t& handle,
                   bool) override {
    void* const sample = create_data();
    const bool made = from_payload(payload, sample) && hash_key(sample, handle);
    delete_data(sample);
    return made;
  }
  bool compute_key(const void* const sample, rtps::InstanceHandle_t& handle, bool) override {
    return hash_key(sample, handle);
  }
#else
  bool serialize(void* sample, rtps::SerializedPayload_t* payload) override {
    return to_payload(sample, *payload);
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* sample) override {
    return from_payload(*payload, sample);
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* sample) override {
    return [this, sample] { return most_octets(sample); };
  }
  bool getKey(void* sample, rtps::InstanceHandle_t* handle, bool) override {
    return hash_key(sample, *handle);
  }
#endif
};

/// The same with the samples' own type.
template <class Sample>
class TypeOf : public HandWrittenType {
 public:
  using HandWrittenType::HandWrittenType;

 private:
#if DDSSEC_FASTDDS >= 3
  void* create_data() override { return new Sample; }
  void delete_data(void* sample) override { delete static_cast<Sample*>(sample); }
#else
  void* createData() override { return new Sample; }
  void deleteData(void* sample) override { delete static_cast<Sample*>(sample); }
#endif
};

/// Makes UDP the only transport, and returns it so that the caller can tune it further.
inline std::shared_ptr<eprosima::fastdds::rtps::UDPv4TransportDescriptor> use_udp_alone(
    fdds::DomainParticipantQos& qos, const char* address) {
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back(address);
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  return udp;
}

// A metatraffic locator with port 0 keeps Fast DDS off multicast.
inline void use_unicast_alone(fdds::DomainParticipantQos& qos, const char* address,
                              const char* peer) {
  rtps::Locator_t own, other;
  rtps::IPLocator::setIPv4(own, address);
  rtps::IPLocator::setIPv4(other, peer);
  auto& builtin = qos.wire_protocol().builtin;
  builtin.metatrafficUnicastLocatorList.push_back(own);
  builtin.initialPeersList.push_back(other);
  auto& discovery = builtin.discovery_config;
  discovery.leaseDuration_announcementperiod = Duration_t(0, 500'000'000);
  discovery.initial_announcements.period = Duration_t(0, 100'000'000);
}

// Standard output is reserved for the peer's own lines.
inline void log_to_stderr(fdds::Log::Kind least = fdds::Log::Kind::Warning) {
  auto consumer = std::make_unique<fdds::StdoutErrConsumer>();
  consumer->stderr_threshold(fdds::Log::Kind::Info);
  fdds::Log::ClearConsumers();
  fdds::Log::RegisterConsumer(std::move(consumer));
  fdds::Log::SetVerbosity(least);
}

}  // namespace interop_fast

#endif
