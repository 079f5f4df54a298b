// CONTENT_FILTER_PROPERTY, with which a reader announces its content filter (RTPS 2.5, 8.7.3.1).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/reader.hpp"
#include "rtps/filter/filter.hpp"
#include "wire/content_filter_info.hpp"

namespace ddssec::rtps {

class SpanWriter;

/// The only supported filter class: DDS 1.4, Annex B.
inline constexpr std::string_view kDdsSql = "DDSSQL";

/// The content filter that a reader announces (PID_CONTENT_FILTER_PROPERTY). Not yet compiled or
/// checked.
struct ContentFilterProperty {
  std::string content_filtered_topic_name;
  std::string related_topic_name;
  std::string filter_class_name = std::string(kDdsSql);
  FilterText filter;
  bool operator==(const ContentFilterProperty&) const = default;
};

/// Returns the digest of all strings in their order, each with its NUL (RTPS 2.5, 9.6.4.1).
FilterSignature signature_of(const ContentFilterProperty& property);

/// Reads the property. Empty for one that exceeds the limits of a filter, or has an empty string
/// where none is allowed: the reader then filters by itself. Errors: those of Reader.
Result<std::optional<ContentFilterProperty>> read_content_filter_property(Reader& reader);
void write_content_filter_property(SpanWriter& out, const ContentFilterProperty& property);

}  // namespace ddssec::rtps
