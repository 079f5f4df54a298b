// The functions behind the table of commands, one file a group.
#pragma once

#include "cli/command.hpp"

namespace ddssec::cli {

Result<Report> ca_create(const Arguments& arguments, const Context& context);
Result<Report> ca_show(const Arguments& arguments, const Context& context);
Result<Report> identity_issue(const Arguments& arguments, const Context& context);
Result<Report> identity_show(const Arguments& arguments, const Context& context);
Result<Report> governance_sign(const Arguments& arguments, const Context& context);
Result<Report> governance_verify(const Arguments& arguments, const Context& context);
Result<Report> permissions_sign(const Arguments& arguments, const Context& context);
Result<Report> permissions_verify(const Arguments& arguments, const Context& context);
Result<Report> can(const Arguments& arguments, const Context& context);
Result<Report> explain(const Arguments& arguments, const Context& context);

}  // namespace ddssec::cli
