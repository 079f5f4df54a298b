#include "pki/crl.hpp"

#include "pki/openssl.hpp"
#include "pki/source.hpp"

namespace ddssec::pki {
namespace {

constexpr std::uint8_t kDerSequence = 0x30;

Result<Crl> from_der(BytesView der) {
  const auto* position = der.data();
  CrlPtr crl(d2i_X509_CRL(nullptr, &position, static_cast<long>(der.size())));
  if (!crl) return openssl_failure(Code::crl_malformed);
  if (position != der.data() + der.size())
    return fail(Code::crl_malformed, {.note = "octets follow the list"});
  auto out = std::make_shared<Crl::Impl>();
  out->issuer = name_rfc2253(X509_CRL_get_issuer(crl.get()));
  const auto this_update = to_wall_time(X509_CRL_get0_lastUpdate(crl.get()));
  if (!this_update) return fail(Code::crl_malformed, {.field = "thisUpdate"});
  out->this_update = *this_update;
  if (const auto* next = X509_CRL_get0_nextUpdate(crl.get())) {
    const auto next_update = to_wall_time(next);
    if (!next_update) return fail(Code::crl_malformed, {.field = "nextUpdate"});
    out->next_update = *next_update;
  }
  out->crl = std::move(crl);
  return Crl(std::move(out));
}

Result<std::vector<Crl>> from_pem(BytesView octets) {
  const BioPtr bio = bio_over(octets);
  std::vector<Crl> out;
  for (;;) {
    auto block = next_pem_block(bio.get());
    if (!block) return fail(Code::crl_malformed, block.error().details());
    if (!*block) return out;
    if ((*block)->label != "X509 CRL") continue;
    if (out.size() == kMostCrlsInFile)
      return fail(Code::crl_too_large,
                  {.expected = "at most " + std::to_string(kMostCrlsInFile) + " lists in a file"});
    out.push_back(DDSSEC_TRY(from_der((*block)->der)));
  }
}

}  // namespace

Result<std::vector<Crl>> Crl::all_from(BytesView octets) {
  if (octets.size() > kMostDocumentOctets)
    return fail(Code::crl_too_large,
                {.expected = "at most " + std::to_string(kMostDocumentOctets) + " octets",
                 .found = std::to_string(octets.size())});
  if (octets.empty() || octets[0] != kDerSequence) return from_pem(octets);
  return std::vector<Crl>{DDSSEC_TRY(from_der(octets))};
}

const std::string& Crl::issuer() const { return impl_->issuer; }
WallTime Crl::this_update() const { return impl_->this_update; }
std::optional<WallTime> Crl::next_update() const { return impl_->next_update; }

std::string Crl::pem() const {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509_CRL(bio.get(), impl_->crl.get()) != 1) return {};
  return std::string(as_text(bio_octets(bio)));
}

}  // namespace ddssec::pki
