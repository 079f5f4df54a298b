// The scope of a local endpoint: topic, partitions and data tags. Access control passes it to
// cryptography through the host in ac_endpoint_properties, which the host does not read.
#pragma once

#include <cstdint>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/value_translation.hpp"

namespace ddssec::cyclonedds {

/// Fills `out` with the id of the endpoint's access control context (unique within the process),
/// and its topic, partitions and data tags. It contains the values themselves, so that no table of
/// endpoints is needed. Errors: out_of_memory, text_holds_nul; `out` is empty then.
Status make_scope(std::uint64_t access_control, const spi::EndpointRequest& request,
                  DDS_Security_PropertySeq& out);

/// True if make_scope made the properties.
bool is_scope(const DDS_Security_PropertySeq& properties);

/// Frees a scope of make_scope and empties it; other properties are left alone.
void free_scope(DDS_Security_PropertySeq& properties) noexcept;

/// A parsed scope. It owns its lists; the texts are borrowed from the host's properties.
class EndpointScope {
 public:
  /// Parses a scope. Error: malformed.
  static Result<EndpointScope> from(const DDS_Security_PropertySeq& properties);
  std::uint64_t access_control() const { return access_control_; }
  spi::EndpointRequest request() const {
    return {.topic_name = topic_, .partitions = partitions_, .data_tags = data_tags_};
  }

 private:
  std::uint64_t access_control_ = 0;
  std::string_view topic_;
  std::vector<std::string_view> partitions_;
  spi::PropertyList data_tags_;
};

}  // namespace ddssec::cyclonedds
