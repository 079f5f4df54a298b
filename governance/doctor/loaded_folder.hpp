// A participant's folder, loaded piece by piece: what is broken does not hide what else is.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "governance/doctor/measured.hpp"
#include "governance/model.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/participant_folder.hpp"
#include "pki/private_key.hpp"
#include "pki/smime.hpp"
#include "pki/smime_diagnosis.hpp"

namespace ddssec::governance::doctor {

/// A signed document of a folder. `Model` is Governance or Permissions.
template <class Model>
struct LoadedDocument {
  /// Why the file cannot be read; success if it can.
  Status readable = {};
  Bytes file = {};
  pki::DocumentForm form = {};
  /// Whether each product believes the signature; see believes().
  Status cyclonedds_belief = {};
  Status fastdds_belief = {};
  Status our_belief = {};
  /// What the document says, even if its signature is wrong; null if it cannot be read.
  std::shared_ptr<const Model> model = {};
  /// Why ours does not read it.
  Status parsed = {};
  /// What was left out of the text so that it could be read, since stock products may skip it.
  std::vector<Variant> left_out = {};
  /// A comment or CDATA in a value was left out, too.
  bool has_joined_values = false;
  /// Names of elements in capitals, which Cyclone DDS takes, were read as small letters.
  bool has_capital_names = false;

  /// Whether a product reads it, as far as its own reader may differ. Error: why ours does not.
  Status read_by(Vendor vendor) const {
    return vendor != Vendor::ours && model ? Status() : parsed;
  }
};

/// What of a folder could be loaded. Each Result stands for itself.
struct LoadedFolder {
  pki::ParticipantFolder paths;
  Result<std::vector<pki::Certificate>> identity_cas;
  Result<pki::Certificate> certificate;
  Result<pki::PrivateKey> key;
  Result<std::vector<pki::Certificate>> permissions_cas;
  /// Empty if there is no such file.
  Result<std::vector<pki::Crl>> crls;
  bool has_crl_file;
  /// It holds one list in DER, which is no PEM text.
  bool is_crl_der = false;
  LoadedDocument<Governance> governance;
  LoadedDocument<Permissions> permissions;

  /// True if not one of the files is there: a participant without security.
  bool is_empty() const;
  /// The chain verifier that this participant judges certificates with. Of several revocation lists
  /// in its file stock products read the first (measured). Errors: those of the pieces it needs, or
  /// of ChainVerifier::make.
  Result<pki::ChainVerifier> chain(Vendor judge = Vendor::ours) const;
};

/// Whether a product believes the signed file under a permissions CA file. Cyclone DDS reads the
/// first certificate of it only. Errors: why `cas` cannot be read; those of
/// pki::stock_products_believe or DocumentVerifier::verify.
Status believes(Vendor judge, BytesView file, const Result<std::vector<pki::Certificate>>& cas,
                WallTime now);

/// True for the error of a key on another curve of 256 bits, such as secp256k1. Cyclone DDS looks
/// at the size of an EC key alone: 0.10.2 talks with it (measured).
bool is_key_of_another_curve(const Error& error);

/// Loads every piece; documents are verified as of `now`. Never fails.
LoadedFolder load_folder(const pki::ParticipantFolder& paths, WallTime now);

}  // namespace ddssec::governance::doctor
