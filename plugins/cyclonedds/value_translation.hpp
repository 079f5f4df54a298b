// Converts small values between Cyclone's C types and those of spi: octets, GUIDs, attributes,
// endpoint requests.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/cyclonedds/abi.hpp"
#include "plugins/spi/access_control.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/shared_secret.hpp"

namespace ddssec::cyclonedds {

/// Returns the elements of a sequence, borrowed. Error: null_argument for a length without a
/// buffer.
template <class Sequence>
auto elements_of(const Sequence& sequence)
    -> Result<std::span<const std::remove_pointer_t<decltype(sequence._buffer)>>> {
  if (sequence._buffer == nullptr && sequence._length != 0) return fail(Code::null_argument);
  return std::span<const std::remove_pointer_t<decltype(sequence._buffer)>>(
      sequence._buffer, sequence._buffer != nullptr ? sequence._length : 0);
}

/// Returns the octets, borrowed. Error: null_argument.
Result<BytesView> octets_from(const DDS_Security_OctetSeq* octets);

/// These convert GUIDs, which are in network byte order on both sides.
Guid guid_from(const DDS_Security_GUID_t& guid);
DDS_Security_GUID_t to_c(const Guid& guid);

DDS_Security_ParticipantSecurityAttributes to_c(
    const spi::ParticipantSecurityAttributes& attributes);
DDS_Security_TopicSecurityAttributes to_c(const spi::TopicSecurityAttributes& attributes);
DDS_Security_EndpointSecurityAttributes to_c(const spi::EndpointSecurityAttributes& attributes);

/// Returns the attributes of a reader that must not match any remote writer (closed_readers.hpp).
/// libddssec_cryptography makes no keys for it and accepts none.
DDS_Security_EndpointSecurityAttributes closed_reader_attributes();

spi::ParticipantSecurityAttributes attributes_from(
    const DDS_Security_ParticipantSecurityAttributes& attributes);
spi::EndpointSecurityAttributes attributes_from(
    const DDS_Security_EndpointSecurityAttributes& attributes);

/// The request of an endpoint. It owns its lists; the topic's name and the partitions are borrowed
/// from the host.
class EndpointQuestion {
 public:
  /// Makes the question from the host's values; a null partition or null tags mean none. Error:
  /// null_argument (topic name, an element).
  static Result<EndpointQuestion> from(const char* topic_name,
                                       const DDS_Security_PartitionQosPolicy* partition,
                                       const DDS_Security_DataTags* data_tags);
  spi::EndpointRequest request() const {
    return {.topic_name = topic_name_, .partitions = partitions_, .data_tags = data_tags_};
  }

 private:
  std::string_view topic_name_;
  std::vector<std::string_view> partitions_;
  spi::PropertyList data_tags_;
};

/// Reads the memory behind the handle. Error: foreign_shared_secret.
Result<spi::SharedSecret> shared_secret_from(DDS_Security_SharedSecretHandle handle);

}  // namespace ddssec::cyclonedds
