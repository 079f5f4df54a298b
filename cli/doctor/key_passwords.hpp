// The passwords that a participant's files give the products for an encrypted key.
#pragma once

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::cli {

/// Opens the folder's key, if it is encrypted, and notes which products are given a password that
/// opens it: Cyclone DDS by <Password> of the configuration that CYCLONEDDS_URI names, or of
/// cyclonedds.xml; Fast DDS by fastdds.xml; ddssec's plugins by security.properties, and in Cyclone
/// DDS as that is.
void open_key(governance::doctor::LoadedFolder& folder);

}  // namespace ddssec::cli
