#include "governance/doctor/diagnosis.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "governance/doctor/checks.hpp"

namespace ddssec::governance::doctor {
namespace {

std::string title_of(Rule rule, std::string_view about) {
  const std::string title(info(rule).title);
  return about.empty() ? title : std::string(about) + ": " + title;
}

std::vector<std::string> concerned(const Outcomes& outcomes, const Lineup& lineup) {
  std::vector<std::string> out;
  for (const auto product : kProducts)
    if (outcomes.of(product) != Outcome::ok) out.push_back(id(product, lineup));
  return out.size() == kProducts.size() ? std::vector<std::string>() : out;
}

}  // namespace

Check& Diagnosis::check_for(Rule rule, std::string_view about) {
  auto title = title_of(rule, about);
  const auto found = std::ranges::find_if(
      checks_, [&](const Check& check) { return check.rule == rule && check.title == title; });
  if (found != checks_.end()) return *found;
  checks_.push_back({rule, std::move(title)});
  return checks_.back();
}

void Diagnosis::pass(Rule rule, std::string_view about) { check_for(rule, about); }

void Diagnosis::report(Outcomes outcomes, Finding finding, std::string_view about) {
  auto& check = check_for(finding.rule, about);
  if (finding.products.empty()) finding.products = concerned(outcomes, lineup_);
  check.outcomes = check.outcomes.worse(outcomes);
  check.findings.push_back(std::move(finding));
}

void Diagnosis::append(Diagnosis other) {
  for (auto& check : other.checks_) {
    const auto own = std::ranges::find_if(checks_, [&](const Check& one) {
      return one.rule == check.rule && one.title == check.title;
    });
    if (own == checks_.end()) {
      checks_.push_back(std::move(check));
      continue;
    }
    own->outcomes = own->outcomes.worse(check.outcomes);
    std::ranges::move(check.findings, std::back_inserter(own->findings));
  }
}

Outcomes Diagnosis::outcomes() const {
  Outcomes worst;
  for (const auto& check : checks_) worst = worst.worse(check.outcomes);
  return worst;
}

std::string clock_hint(WallTime now) {
  return fmt::format(
      "this machine's clock says {}: is it behind? date and timedatectl show it; if it is right, "
      "wait, or fetch what is valid now",
      to_string(now));
}

std::string hint_if_early(WallTime begin, WallTime now) {
  return begin > now ? clock_hint(now) : std::string();
}

Diagnosis diagnose(const LoadedFolder& folder, const Settings& settings) {
  Diagnosis out(settings.lineup);
  diagnose_files(folder, settings, out);
  diagnose_identity(folder, settings, out);
  diagnose_documents(folder, settings, out);
  diagnose_rights(folder, settings, out);
  diagnose_readings(folder, settings, out);
  diagnose_ends(folder, settings, out);
  return out;
}

}  // namespace ddssec::governance::doctor
