// Opens keys with the passwords that a participant's files give the products.
#pragma once

#include "governance/doctor/loaded_folder.hpp"

namespace ddssec::cli {

/// Opens the folder's key if it is encrypted, and notes which products get a password that opens
/// it. Cyclone DDS gets it from <Password> of the configuration that CYCLONEDDS_URI names, or of
/// cyclonedds.xml; Fast DDS from fastdds.xml. ddssec's plugins get it from security.properties, and
/// within Cyclone DDS as Cyclone DDS does.
void open_key(governance::doctor::LoadedFolder& folder);

}  // namespace ddssec::cli
