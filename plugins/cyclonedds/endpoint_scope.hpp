// What one of our endpoints is about, as access control hands it to cryptography through the host:
// in ac_endpoint_properties, which the host passes on unread.
#pragma once

#include <cstdint>

#include "plugins/cyclonedds/abi.hpp"
#include "plugins/cyclonedds/value_translation.hpp"

namespace ddssec::cyclonedds {

/// Fills `out` with which access control context the endpoint belongs to (ids are unique within the
/// process) and its topic, partitions and data tags. It holds the values themselves, so that no
/// table of endpoints has to be kept. Errors: out_of_memory, text_holds_nul; `out` is empty then.
Status make_scope(std::uint64_t access_control, const spi::EndpointRequest& request,
                  DDS_Security_PropertySeq& out);

/// Was it made by make_scope?
bool is_scope(const DDS_Security_PropertySeq& properties);

/// Frees what make_scope made, once; other properties are left alone.
void free_scope(DDS_Security_PropertySeq& properties) noexcept;

/// A scope read back, with the lists it borrows; the texts stay the host's.
class EndpointScope {
 public:
  /// Error: malformed.
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
