#include "rtps/discovery/content_filter_property.hpp"

#include "base/hash.hpp"
#include "rtps/discovery/parameter_table.hpp"
#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

FilterSignature signature_of(const ContentFilterProperty& property) {
  Bytes all;
  const auto add = [&](std::string_view text) {
    all.insert(all.end(), text.begin(), text.end());
    all.push_back(0);
  };
  add(property.content_filtered_topic_name);
  add(property.related_topic_name);
  add(property.filter_class_name);
  add(property.filter.expression);
  for (const auto& parameter : property.filter.parameters) add(parameter);
  return md5(all);
}

Result<std::optional<ContentFilterProperty>> read_content_filter_property(Reader& reader) {
  ContentFilterProperty out;
  bool usable = true;
  const auto read_text = [&](std::string& text, std::size_t max_length) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto read, reader.read_string());
    usable = usable && read.size() <= max_length;
    if (usable) text = read;
    return {};
  };
  const auto read_required = [&](std::string& text, std::size_t max_length) -> Status {
    DDSSEC_RETURN_IF_ERROR(read_text(text, max_length));
    usable = usable && !text.empty();
    return {};
  };
  DDSSEC_RETURN_IF_ERROR(read_required(out.content_filtered_topic_name, kMaxNameLength));
  DDSSEC_RETURN_IF_ERROR(read_required(out.related_topic_name, kMaxNameLength));
  DDSSEC_RETURN_IF_ERROR(read_required(out.filter_class_name, kMaxNameLength));
  DDSSEC_RETURN_IF_ERROR(read_required(out.filter.expression, Filter::kMaxExpression));
  DDSSEC_ASSIGN_OR_RETURN(const auto count, reader.read_count(4));
  usable = usable && count <= Filter::kMaxParameters;
  for (std::uint32_t i = 0; i < count && usable; ++i)
    DDSSEC_RETURN_IF_ERROR(read_text(out.filter.parameters.emplace_back(), Filter::kMaxParameter));
  if (!usable) return std::nullopt;
  return out;
}

void write_content_filter_property(SpanWriter& out, const ContentFilterProperty& property) {
  const ParameterScope scope(out, pid::kContentFilterProperty);
  write_text(out, property.content_filtered_topic_name);
  write_text(out, property.related_topic_name);
  write_text(out, property.filter_class_name);
  write_text(out, property.filter.expression);
  out.align(4);
  out.write(static_cast<std::uint32_t>(property.filter.parameters.size()));
  for (const auto& parameter : property.filter.parameters) write_text(out, parameter);
}

}  // namespace ddssec::rtps
