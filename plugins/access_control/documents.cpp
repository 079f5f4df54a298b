#include "plugins/access_control/documents.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::access_control {

Result<std::shared_ptr<const PermissionsCa>> PermissionsCa::load(const std::string& uri) {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto file,
      pki::load_certificates(uri, spi::property::kPermissionsCa, pki::kMaxBundleOctets));
  DDSSEC_ASSIGN_OR_RETURN(auto bundle, pki::Certificate::bundle_from_pem(file));
  return of(std::move(bundle));
}

Result<std::shared_ptr<const PermissionsCa>> PermissionsCa::of(
    std::vector<pki::Certificate> authorities) {
  Bytes fingerprints;
  for (const auto& certificate : authorities) {
    const auto& f = certificate.fingerprint();
    fingerprints.insert(fingerprints.end(), f.begin(), f.end());
  }
  DDSSEC_ASSIGN_OR_RETURN(auto verifier, pki::DocumentVerifier::make(std::move(authorities)));
  return std::make_shared<const PermissionsCa>(std::move(verifier), sha256(fingerprints));
}

bool PermissionsCa::holds(const pki::Certificate& signer) const {
  return std::ranges::find(verifier_.permissions_cas(), signer) !=
         verifier_.permissions_cas().end();
}

PermissionsDocument::PermissionsDocument(governance::Permissions permissions,
                                         const pki::SignedDocument& document)
    : permissions_(std::make_shared<const governance::Permissions>(std::move(permissions))),
      signer_not_before_(document.signer().not_before()),
      signer_not_after_(document.signer_not_after()),
      signer_(document.signer()),
      signing_time_(document.signing_time()) {}

Status PermissionsDocument::check_signer(WallTime now) const {
  const bool early = now < signer_not_before_;
  if (!early && now <= signer_not_after_) return {};
  return fail(early ? Code::certificate_not_yet_valid : Code::certificate_expired,
              {.field = early ? "notBefore" : "notAfter",
               .expected = to_string(early ? signer_not_before_ : signer_not_after_),
               .found = to_string(now),
               .note = "permissions CA " + signer_.subject()});
}

bool PermissionsDocument::has_grant_for(const pki::SubjectName& subject) const {
  return std::ranges::any_of(permissions_->grants,
                             [&](const auto& grant) { return governance::is_for(grant, subject); });
}

Result<SharedGrant> PermissionsDocument::grant_for(const pki::SubjectName& subject,
                                                   std::string_view shown, DomainId domain,
                                                   const std::string& tag, WallTime now) {
  DDSSEC_RETURN_IF_ERROR(check_signer(now));
  DDSSEC_ASSIGN_OR_RETURN(const governance::Grant* grant,
                          governance::find_grant(*permissions_, subject, shown, now));
  return compiled(*grant, domain, tag);
}

SharedGrant PermissionsDocument::compiled(const governance::Grant& grant, DomainId domain,
                                          const std::string& tag) {
  const std::lock_guard lock(mutex_);
  const std::tuple key(&grant, domain, tag);
  if (compiled_.size() >= kMaxCompiled && !compiled_.contains(key)) compiled_.clear();
  auto& out = compiled_[key];
  if (!out)
    out = std::make_shared<const governance::CompiledGrant>(permissions_, grant, domain,
                                                            partition_match_, tag);
  return out;
}

Result<std::shared_ptr<PermissionsDocument>> DocumentCache::permissions(const PermissionsCa& ca,
                                                                        BytesView file,
                                                                        WallTime now) {
  const Sha256Digest form = sha256({ca.digest(), file});
  if (auto known = find(by_form_, form)) {
    DDSSEC_RETURN_IF_ERROR(known->check_signer(now));
    return known;
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto document, ca.verifier().verify(file, now));
  // A text that was signed again is another document, and the later one is in force
  // (check_follows).
  const auto signing_time = document.signing_time() ? to_string(*document.signing_time()) : "";
  const Sha256Digest text = sha256({ca.digest(), document.signer().fingerprint(),
                                    sha256(as_bytes(signing_time)), document.content()});
  if (auto known = find(by_text_, text)) {
    add_form(text, form);
    return known;
  }
  DDSSEC_ASSIGN_OR_RETURN(auto permissions,
                          governance::read_permissions(document.content(), document.first_line()));
  auto judged = std::make_shared<PermissionsDocument>(std::move(permissions), document);
  judged->set_partition_match(partition_match_);
  insert({text, file.size(), judged});
  add_form(text, form);
  return judged;
}

std::shared_ptr<PermissionsDocument> DocumentCache::find(Places& places, const Sha256Digest& key) {
  const std::lock_guard lock(mutex_);
  const auto known = places.find(key);
  if (known == places.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, known->second);
  return known->second->document;
}

void DocumentCache::add_form(const Sha256Digest& text, const Sha256Digest& form) {
  const std::lock_guard lock(mutex_);
  const auto known = by_text_.find(text);
  if (known == by_text_.end() || by_form_.contains(form)) return;
  auto& forms = known->second->forms;
  forms.reserve(kMaxForms + 1);
  by_form_[form] = known->second;
  forms.push_back(form);
  if (forms.size() <= kMaxForms) return;
  by_form_.erase(forms.front());
  forms.erase(forms.begin());
}

void DocumentCache::insert(Entry entry) {
  const std::lock_guard lock(mutex_);
  if (by_text_.contains(entry.text)) return;  // two threads read it at the same time
  entries_.push_front(std::move(entry));
  Rollback forget([&] { entries_.pop_front(); });
  by_text_[entries_.front().text] = entries_.begin();
  forget.release();
  octets_ += entries_.front().octets;
  while (entries_.size() > max_documents_ || (octets_ > max_octets_ && entries_.size() > 1))
    drop_oldest();
}

void DocumentCache::drop_oldest() {
  const auto& oldest = entries_.back();
  octets_ -= oldest.octets;
  for (const auto& form : oldest.forms) by_form_.erase(form);
  by_text_.erase(oldest.text);
  entries_.pop_back();
}

std::size_t DocumentCache::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

}  // namespace ddssec::access_control
