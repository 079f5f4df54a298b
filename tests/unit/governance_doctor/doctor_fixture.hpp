// What the tests of governance/doctor/ share: a participant's folder on disk, whole or broken.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include "governance/doctor/diagnosis.hpp"
#include "governance/write.hpp"
#include "pki/authority.hpp"
#include "tests/support/test_ca.hpp"

namespace ddssec::governance::doctor {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

/// 2026-11-21T00:00:00Z, a day on which everything made here is valid.
using test::kNow;
using test::kYear;
using test::make_ca;
using test::make_leaf;
using test::test_random;

/// Returns a domain rule like that of sros2, with one topic rule for everything.
inline Governance strict_governance(DomainId domain = 0) {
  Governance out;
  out.domain_rules.push_back({.domains = {.ranges = {{domain, domain}}},
                              .rtps_protection_kind = ProtectionKind::sign,
                              .topic_rules = {{.topic_expression = "*"}}});
  return out;
}

/// Returns a grant that allows topics in both directions.
inline Grant grant_for(std::string subject, std::string topic = "Square", DomainId domain = 0) {
  governance::GrantRule rule{.allow = true, .domains = {.ranges = {{domain, domain}}}};
  rule.publish.push_back({.topics = {{topic}}});
  rule.subscribe.push_back({.topics = {{topic}}});
  return {.name = "participant",
          .subject_name = std::move(subject),
          .validity = {kNow - 48h, kNow + 365 * 24h},
          .rules = {std::move(rule)}};
}

/// Two CAs and the participants below them, in a temporary folder.
class Folders : public testing::Test {
 protected:
  Folders() {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    // Several programs may run at once.
    root_ = fs::path(testing::TempDir()) /
            ("ddssec-doctor-" + std::string(info->name()) + '-' + std::to_string(::getpid()));
  }
  ~Folders() override { fs::remove_all(root_); }

  /// Writes the folder of a correct participant.
  pki::ParticipantFolder participant(const std::string& name) {
    return participant(name, strict_governance(), {.grants = {grant_for("CN=" + name)}});
  }
  pki::ParticipantFolder participant(const std::string& name, const Governance& governance,
                                     const Permissions& permissions) {
    const auto folder = pki::participant_folder(root_ / name, pki::FolderLayout::flat);
    fs::create_directories(folder.folder);
    const auto self = make_leaf(identity_ca_, "CN=" + name);
    write(folder.identity_ca, identity_ca_.certificate().pem());
    write(folder.permissions_ca, permissions_ca_.certificate().pem());
    write(folder.certificate, self.certificate.pem());
    const auto& ca = identity_ca_.certificate();
    write(folder.crl, identity_ca_
                          .make_crl({.this_update = ca.not_before(),
                                     .next_update = ca.not_after(),
                                     .number = 1,
                                     .entries = {}})
                          ->pem());
    self.key.to_pem()->expose(
        [&](BytesView octets) { write(folder.key, std::string(as_text(octets))); });
    fs::permissions(folder.key, fs::perms::owner_read | fs::perms::owner_write);
    sign(folder.governance, to_xml(governance));
    sign(folder.permissions, to_xml(permissions));
    return folder;
  }

  void write(const fs::path& path, const std::string& text) const {
    std::ofstream(path, std::ios::binary) << text;
  }
  void sign(const fs::path& path, const std::string& xml) const {
    const auto file = permissions_ca_.sign_document(as_bytes(xml), kNow, test_random());
    ASSERT_TRUE(file) << file.error().to_sentence();
    write(path, std::string(as_text(*file)));
  }
  std::string read(const fs::path& path) const {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  Diagnosis diagnosis(const pki::ParticipantFolder& folder, WallTime now = kNow) const {
    return diagnose(load_folder(folder, now), {.now = now});
  }

  fs::path root_;
  pki::Authority identity_ca_ = make_ca("CN=Identity CA");
  pki::Authority permissions_ca_ = make_ca("CN=Permissions CA");
};

/// Returns the rules of all findings, in order.
inline std::vector<Rule> rules_of(const Diagnosis& diagnosis) {
  std::vector<Rule> out;
  for (const auto& check : diagnosis.checks())
    for (const auto& finding : check.findings) out.push_back(finding.rule);
  return out;
}

/// Returns the first finding of a rule.
inline Finding finding_of(const Diagnosis& diagnosis, Rule rule) {
  for (const auto& check : diagnosis.checks())
    for (const auto& finding : check.findings)
      if (finding.rule == rule) return finding;
  ADD_FAILURE() << "no finding of " << info(rule).id;
  return {rule, ""};
}

}  // namespace ddssec::governance::doctor
