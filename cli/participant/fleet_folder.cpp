#include "cli/participant/fleet_folder.hpp"

#include <algorithm>
#include <iterator>
#include <system_error>

#include <fmt/format.h>

#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/inputs/files.hpp"
#include "cli/participant/configuration_files.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

namespace fs = std::filesystem;

Result<FleetFolder> FleetFolder::at(const fs::path& target, std::vector<ParticipantSpec>& specs) {
  DDSSEC_RETURN_IF_ERROR(check_nameable(target));
  FleetFolder out(target);
  const auto has = [&](const ParticipantSpec& spec) { return out.has(spec); };
  std::error_code ignored;
  out.is_growing_ = fs::symlink_status(target, ignored).type() == fs::file_type::directory &&
                    std::ranges::any_of(specs, has);
  if (!out.is_growing_) {
    DDSSEC_ASSIGN_OR_RETURN(auto new_folder, NewFolder::at(target));
    out.parts_.push_back(std::move(new_folder));
    return out;
  }
  out.kept_ = std::erase_if(specs, has);
  if (specs.empty())
    return fail(Code::would_overwrite,
                {.document = target,
                 .note = "it has every participant of the file",
                 .hint = "ddssec identity issue NAME --ca CA -o DIR --replace makes one of them "
                         "again; ddssec permissions new --replace changes its permissions alone"});
  for (const auto& spec : specs) {
    DDSSEC_ASSIGN_OR_RETURN(auto new_folder, NewFolder::at(target / spec.name));
    out.parts_.push_back(std::move(new_folder));
  }
  return out;
}

Status FleetFolder::add(std::size_t index, const std::string& name, const NewParticipant& made,
                        const Issuers& issuers, BytesView governance) {
  return is_growing_ ? add_flat(parts_[index], "", made, issuers, governance)
                     : add_flat(parts_.front(), name, made, issuers, governance);
}

Result<std::vector<WrittenFile>> FleetFolder::commit() {
  std::vector<WrittenFile> out;
  for (auto& part : parts_) {
    DDSSEC_ASSIGN_OR_RETURN(auto files, part.commit());
    std::ranges::move(files, std::back_inserter(out));
  }
  return out;
}

std::string FleetFolder::text() const {
  std::string out =
      "each folder has cyclonedds.xml and fastdds.xml, which name its files by their whole paths\n";
  if (kept_ > 0)
    out += fmt::format("{} of the file: left as before, with the rights of before\n",
                       count_text(kept_, "earlier participant"));
  return out;
}

bool FleetFolder::has(const ParticipantSpec& spec) const {
  return path_exists(
      pki::participant_folder(target_ / spec.name, pki::FolderLayout::flat).certificate);
}

IssuedFacts FleetMembers::add(const std::string& name, const NewParticipant& made) {
  const auto place = target_ / name;
  issued_ += log_line(made, place, now_);
  if (permissions_ != nullptr) signed_ += signed_line(made, *permissions_, place, now_);
  return {name, place, CertificateFacts::of(made.self.certificate)};
}

}  // namespace ddssec::cli
