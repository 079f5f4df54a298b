// Values of options about a new participant.
#pragma once

#include <string>
#include <string_view>

#include "cli/frame/command.hpp"

namespace ddssec::cli {

/// Success if `name` is a valid name for a participant's folder. `any_other` says how a certificate
/// gets any other name, for a command without --subject. Error: name_unusable.
Status check_name(std::string_view name, std::string_view any_other = {});

/// The URL of --ocsp-responder; empty if it is not given. Error: usage.
Result<std::string> ocsp_responder(const Arguments& arguments);

}  // namespace ddssec::cli
