#include "plugins/cyclonedds/endpoint_scope.hpp"

#include <charconv>
#include <string>

#include "plugins/cyclonedds/token_translation.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr std::string_view kAccessControl = "org.ddssec.access_control";
constexpr std::string_view kTopic = "org.ddssec.topic";
constexpr std::string_view kPartition = "org.ddssec.partition";
constexpr std::string_view kTag = "org.ddssec.tag.";  // the name of the tag follows

std::optional<std::uint64_t> number_in(std::string_view text) {
  std::uint64_t number = 0;
  const auto* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

}  // namespace

Status make_scope(std::uint64_t access_control, const spi::EndpointRequest& request,
                  DDS_Security_PropertySeq& out) {
  spi::PropertyList list = {{std::string(kAccessControl), std::to_string(access_control)},
                            {std::string(kTopic), std::string(request.topic_name)}};
  for (const auto partition : request.partitions)
    list.push_back({std::string(kPartition), std::string(partition)});
  for (const auto& tag : request.data_tags)
    list.push_back({std::string(kTag) + tag.name, tag.value});
  return copy_properties(list, out);
}

bool is_scope(const DDS_Security_PropertySeq& properties) {
  return properties._buffer != nullptr && properties._length != 0 &&
         properties._buffer[0].name != nullptr && properties._buffer[0].name == kAccessControl;
}

void free_scope(DDS_Security_PropertySeq& properties) noexcept {
  if (is_scope(properties)) free_properties(properties);
}

Result<EndpointScope> EndpointScope::from(const DDS_Security_PropertySeq& properties) {
  EndpointScope scope;
  bool has_number = false, has_topic = false;
  DDSSEC_ASSIGN_OR_RETURN(const auto elements, elements_of(properties));
  for (const auto& property : elements) {
    if (property.name == nullptr || property.value == nullptr) return fail(Code::malformed);
    const std::string_view name = property.name, value = property.value;
    if (name == kAccessControl) {
      const auto number = number_in(value);
      if (!number) return fail(Code::malformed, {.field = std::string(name)});
      scope.access_control_ = *number;
      has_number = true;
    } else if (name == kTopic) {
      scope.topic_ = value;
      has_topic = true;
    } else if (name == kPartition) {
      scope.partitions_.push_back(value);
    } else if (name.starts_with(kTag)) {
      scope.data_tags_.push_back({std::string(name.substr(kTag.size())), std::string(value)});
    }
  }
  if (!has_number || !has_topic) return fail(Code::malformed);
  return scope;
}

}  // namespace ddssec::cyclonedds
