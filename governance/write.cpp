#include "governance/write.hpp"

#include <fmt/format.h>

#include "base/clock.hpp"

namespace ddssec::governance {
namespace {

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string revision_line(std::uint32_t revision) {
  return fmt::format("<?ddssec revision=\"{}\"?>\n", revision);
}

// Lines of XML, indented by two blanks for each level.
class Out {
 public:
  explicit Out(std::uint32_t revision = 0) : text_("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n") {
    if (revision != 0) text_ += revision_line(revision);
  }

  void value(std::string_view name, std::string_view content) {
    text_ += fmt::format("{:{}}<{}>{}</{}>\n", "", indent_, name, escaped(content), name);
  }
  void value(std::string_view name, bool content) {
    value(name, std::string_view(content ? "true" : "false"));
  }
  void value(std::string_view name, ProtectionKind kind) { value(name, ddssec::to_string(kind)); }
  void values(std::string_view name, const std::vector<Text>& texts) {
    for (const auto& text : texts) value(name, text.text);
  }

  template <class Inside>
  void element(std::string_view name, Inside&& inside, std::string_view attributes = {}) {
    text_ += fmt::format("{:{}}<{}{}>\n", "", indent_, name, attributes);
    indent_ += 2;
    inside();
    indent_ -= 2;
    text_ += fmt::format("{:{}}</{}>\n", "", indent_, name);
  }

  std::string take() { return std::move(text_); }

 private:
  std::string text_;
  int indent_ = 0;
};

void write(Out& out, const DomainSet& domains) {
  out.element("domains", [&] {
    for (const auto& range : domains.ranges) {
      if (range.first == range.last) {
        out.value("id", std::to_string(range.first));
        continue;
      }
      out.element("id_range", [&] {
        out.value("min", std::to_string(range.first));
        out.value("max", std::to_string(range.last));
      });
    }
    out.values("tag", domains.tags);
    out.values("tag_expression", domains.tag_expressions);
  });
}

void write(Out& out, const TopicRule& rule) {
  out.element("topic_rule", [&] {
    out.value("topic_expression", rule.topic_expression);
    out.value("enable_discovery_protection", rule.enable_discovery_protection);
    out.value("enable_liveliness_protection", rule.enable_liveliness_protection);
    out.value("enable_read_access_control", rule.enable_read_access_control);
    out.value("enable_write_access_control", rule.enable_write_access_control);
    out.value("metadata_protection_kind", rule.metadata_protection_kind);
    out.value("data_protection_kind", rule.data_protection_kind);
  });
}

void write_algorithms(Out& out, std::string_view name, const std::vector<Text>& algorithms) {
  if (algorithms.empty()) return;
  out.element(name, [&] { out.values("algorithm", algorithms); });
}

void write(Out& out, const AllowedAlgorithms& allowed) {
  out.element("allowed_crypto_algorithms", [&] {
    write_algorithms(out, "digital_signature", allowed.digital_signature);
    write_algorithms(out, "digital_signature_identity_trust_chain",
                     allowed.digital_signature_identity_trust_chain);
    write_algorithms(out, "key_establishment", allowed.key_establishment);
    write_algorithms(out, "symmetric_cipher", allowed.symmetric_cipher);
  });
}

void write(Out& out, const DomainRule& rule) {
  out.element("domain_rule", [&] {
    write(out, rule.domains);
    out.value("allow_unauthenticated_participants", rule.allow_unauthenticated_participants);
    out.value("enable_join_access_control", rule.enable_join_access_control);
    if (rule.enable_key_revision) out.value("enable_key_revision", true);
    out.value("discovery_protection_kind", rule.discovery_protection_kind);
    out.value("liveliness_protection_kind", rule.liveliness_protection_kind);
    out.value("rtps_protection_kind", rule.rtps_protection_kind);
    if (is_protected(rule.rtps_psk_protection_kind)) {
      out.value("rtps_psk_protection_kind", rule.rtps_psk_protection_kind);
    }
    out.element("topic_access_rules", [&] {
      for (const auto& topic_rule : rule.topic_rules) write(out, topic_rule);
    });
    if (rule.allowed_algorithms) write(out, *rule.allowed_algorithms);
  });
}

void write(Out& out, std::string_view name, const Criteria& criteria) {
  out.element(name, [&] {
    out.element("topics", [&] { out.values("topic", criteria.topics); });
    if (criteria.partitions) {
      out.element("partitions", [&] { out.values("partition", *criteria.partitions); });
    }
    if (!criteria.data_tags) return;
    out.element("data_tags", [&] {
      for (const auto& tag : *criteria.data_tags) {
        out.element("tag", [&] {
          out.value("name", tag.name);
          out.value("value", tag.value);
        });
      }
    });
  });
}

void write(Out& out, const GrantRule& rule) {
  out.element(rule.allow ? "allow_rule" : "deny_rule", [&] {
    write(out, rule.domains);
    for (const auto& criteria : rule.publish) write(out, "publish", criteria);
    for (const auto& criteria : rule.subscribe) write(out, "subscribe", criteria);
    for (const auto& criteria : rule.relay) write(out, "relay", criteria);
  });
}

void write(Out& out, const Grant& grant, std::string_view fallback_name) {
  const auto name = grant.name.empty() ? fallback_name : std::string_view(grant.name);
  const auto inside = [&] {
    out.value(grant.subject_is_expression ? "subject_name_expression" : "subject_name",
              grant.subject_name);
    out.element("validity", [&] {
      out.value("not_before", ddssec::to_string(grant.validity.not_before));
      out.value("not_after", ddssec::to_string(grant.validity.not_after));
    });
    for (const auto& rule : grant.rules) write(out, rule);
    out.value("default", std::string_view(grant.default_allow ? "ALLOW" : "DENY"));
  };
  out.element("grant", inside, fmt::format(" name=\"{}\"", escaped(name)));
}

}  // namespace

std::string with_revision(std::string_view xml, std::uint32_t revision) {
  const auto declaration = xml.find("<?xml");
  const auto first = xml.find('<');
  auto at = first == xml.npos ? 0 : first;
  if (declaration == first && declaration != xml.npos) {
    const auto end = xml.find("?>", declaration);
    at = end == xml.npos ? at : end + 2;
    if (xml.substr(at).starts_with("\r\n")) at += 2;
    if (xml.substr(at).starts_with('\n')) ++at;
  }
  return std::string(xml.substr(0, at)).append(revision_line(revision)).append(xml.substr(at));
}

std::string to_xml(const Governance& governance) {
  Out out(governance.revision);
  out.element("dds", [&] {
    out.element("domain_access_rules", [&] {
      for (const auto& rule : governance.domain_rules) write(out, rule);
    });
  });
  return out.take();
}

std::string to_xml(const Permissions& permissions) {
  Out out;
  out.element("dds", [&] {
    out.element("permissions", [&] {
      for (std::size_t i = 0; i < permissions.grants.size(); ++i) {
        write(out, permissions.grants[i], fmt::format("grant{}", i + 1));
      }
    });
  });
  return out.take();
}

}  // namespace ddssec::governance
