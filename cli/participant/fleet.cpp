#include "cli/participant/fleet.hpp"

#include <algorithm>
#include <unordered_set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#define TOML_EXCEPTIONS 0
#define TOML_ENABLE_FORMATTERS 0
#define TOML_MAX_NESTED_VALUES 16
#include <toml++/toml.h>

#include "cli/frame/suggestions.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/keys.hpp"
#include "cli/inputs/participant_options.hpp"
#include "cli/inputs/times.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

// Also finds keys for "publishes" and "topics_publish", which begin or end with a key.
std::string nearest_key(std::string_view key, const std::vector<std::string>& known) {
  auto near = nearest(key, known);
  if (!near.empty()) return near;
  const auto part = std::ranges::find_if(
      known, [&](const std::string& one) { return one.size() > 3 && key.contains(one); });
  return part == known.end() ? near : *part;
}

// One table of the file, with what error messages need.
class Table {
 public:
  Table(const toml::table& table, const fs::path& file) : table_(table), file_(file) {}

  std::unexpected<Error> malformed_error(std::string field, std::string expected,
                                         const toml::node* where = nullptr) const {
    return fail(Code::fleet_malformed,
                {.document = file_,
                 .line = static_cast<int>((where ? where : &table_)->source().begin.line),
                 .field = std::move(field),
                 .expected = std::move(expected)});
  }

  const toml::node* node(std::string_view key) const { return table_.get(key); }

  Status check_keys(const std::vector<std::string>& known) const {
    for (const auto& [key, value] : table_) {
      if (std::ranges::find(known, key.str()) != known.end()) continue;
      const auto near = nearest_key(key.str(), known);
      return malformed_error(std::string(key.str().substr(0, 64)),
                             fmt::format("one of {}{}", fmt::join(known, ", "),
                                         near.empty() ? "" : did_you_mean({near})),
                             &value);
    }
    return {};
  }

  // Leaves `out` as it is if the key is missing.
  Status read(std::string_view key, std::string& out) const {
    const auto* node = table_.get(key);
    if (node == nullptr) return {};
    const auto value = node->value_exact<std::string>();
    if (!value) return malformed_error(std::string(key), "a text", node);
    out = *value;
    return {};
  }

  Status read(std::string_view key, int lowest, int highest, int& out) const {
    const auto* node = table_.get(key);
    if (node == nullptr) return {};
    const auto value = node->value_exact<std::int64_t>();
    if (!value || *value < lowest || highest < *value)
      return malformed_error(
          std::string(key),
          "a number from " + std::to_string(lowest) + " to " + std::to_string(highest), node);
    out = static_cast<int>(*value);
    return {};
  }

  Status read(std::string_view key, std::vector<std::string>& out) const {
    const auto* node = table_.get(key);
    if (node == nullptr) return {};
    const auto* array = node->as_array();
    if (array == nullptr) return malformed_error(std::string(key), "a list of texts", node);
    out.clear();
    for (const auto& element : *array) {
      const auto value = element.value_exact<std::string>();
      if (!value) return malformed_error(std::string(key), "a list of texts", &element);
      out.push_back(*value);
    }
    return {};
  }

 private:
  const toml::table& table_;
  const fs::path& file_;
};

// Reads the keys that are allowed both at the top and in each participant's table.
Status read_common(const Table& table, ParticipantSpec& spec, WallTime now) {
  int domain = -1;
  DDSSEC_RETURN_IF_ERROR(table.read("domain", 0, governance::kMaxGovernedDomainId, domain));
  if (domain >= 0) spec.domains = {{static_cast<DomainId>(domain), static_cast<DomainId>(domain)}};
  int days = 0;
  DDSSEC_RETURN_IF_ERROR(table.read("days", 1, kMaxDays, days));
  if (days > 0) spec.life = validity_of(days, now);
  std::string key;
  DDSSEC_RETURN_IF_ERROR(table.read("key", key));
  if (!key.empty()) {
    const auto kind = key_spec_of(key, "key");
    if (!kind) return table.malformed_error("key", "p256, rsa2048 or rsa3072", table.node("key"));
    spec.key = *kind;
  }
  DDSSEC_RETURN_IF_ERROR(table.read("publish", spec.publish));
  DDSSEC_RETURN_IF_ERROR(table.read("partitions", spec.partitions));
  return table.read("subscribe", spec.subscribe);
}

Result<ParticipantSpec> participant_of(const toml::table& node, const fs::path& file,
                                       ParticipantSpec spec, WallTime now) {
  const Table table(node, file);
  DDSSEC_RETURN_IF_ERROR(table.check_keys({"name", "subject", "domain", "days", "key", "publish",
                                           "subscribe", "partitions", "permissions"}));
  DDSSEC_RETURN_IF_ERROR(table.read("name", spec.name));
  constexpr auto kAnyOther = "subject = \"CN=...\" gives the certificate any other name";
  if (spec.name.empty()) return table.malformed_error("name", "a participant's name");
  if (const auto fine = check_name(spec.name, kAnyOther); !fine) {
    auto details = fine.error().details();
    details.document = file;
    details.line = static_cast<int>(node.source().begin.line);
    return fail(fine.error().code(), std::move(details));
  }
  spec.subject = "CN=" + spec.name;
  DDSSEC_RETURN_IF_ERROR(table.read("subject", spec.subject));
  DDSSEC_RETURN_IF_ERROR(read_common(table, spec, now));
  std::string permissions;
  DDSSEC_RETURN_IF_ERROR(table.read("permissions", permissions));
  if (!permissions.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(spec.permissions,
                            read_file(file.parent_path() / permissions, pki::kMaxDocumentOctets));
  }
  return spec;
}

// The description of the failure without the part that may quote the file, because a path may lead
// to any file.
std::string without_content(std::string_view description) {
  return std::string(description.substr(0, description.find(": ")));
}

// The parser limits nested values, but not dotted keys ("a.a.a = 1"), whose tables it visits by
// recursion. Such a key is on one line. Dots in strings count as well, because only the parser
// knows where a string ends.
Status check_dots(std::string_view text, const fs::path& file) {
  constexpr int kMaxDotsInLine = 512;
  int line = 1;
  int dots = 0;
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      dots = 0;
    } else if (c == '.' && ++dots > kMaxDotsInLine) {
      return fail(Code::fleet_malformed,
                  {.document = file,
                   .line = line,
                   .expected = fmt::format("at most {} dots in a line", kMaxDotsInLine),
                   .hint = "put each part of a long list on a line of its own"});
    }
  }
  return {};
}

Result<toml::table> parsed(std::string_view text, const fs::path& file) {
  DDSSEC_RETURN_IF_ERROR(check_dots(text, file));
  auto result = toml::parse(text);
  if (result) return std::move(result).table();
  return fail(Code::fleet_malformed, {.document = file,
                                      .line = static_cast<int>(result.error().source().begin.line),
                                      .note = without_content(result.error().description())});
}

}  // namespace

Result<std::vector<ParticipantSpec>> read_fleet(const fs::path& file,
                                                const ParticipantSpec& standard, WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, kMaxFleetOctets));
  DDSSEC_ASSIGN_OR_RETURN(const auto root, parsed(as_text(octets), file));
  const Table top(root, file);
  DDSSEC_RETURN_IF_ERROR(top.check_keys(
      {"domain", "days", "key", "publish", "subscribe", "partitions", "participant"}));
  auto common = standard;
  DDSSEC_RETURN_IF_ERROR(read_common(top, common, now));
  const auto* node = root.get("participant");
  const auto* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr || list->empty() || list->size() > kMaxParticipants)
    return top.malformed_error(
        "participant", "1 to " + std::to_string(kMaxParticipants) + " tables [[participant]]");
  std::vector<ParticipantSpec> out;
  std::unordered_set<std::string> names;
  for (const auto& element : *list) {
    const auto* table = element.as_table();
    if (table == nullptr)
      return top.malformed_error("participant", "tables [[participant]]", &element);
    DDSSEC_ASSIGN_OR_RETURN(auto participant, participant_of(*table, file, common, now));
    out.push_back(std::move(participant));
    if (!names.insert(out.back().name).second)
      return top.malformed_error(
          "name", "every name once; \"" + out.back().name + "\" is there twice", table);
  }
  return out;
}

}  // namespace ddssec::cli
