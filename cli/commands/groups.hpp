// The groups of the table of commands. Each group's file contains its rows and their functions.
#pragma once

#include "cli/frame/command.hpp"

namespace ddssec::cli {

std::vector<Command> init_commands();
std::vector<Command> ca_commands();
std::vector<Command> ca_rotate_commands();
std::vector<Command> identity_issue_commands();
std::vector<Command> identity_commands();  ///< the commands identity show, csr, sign-csr
std::vector<Command> governance_commands();
std::vector<Command> permissions_commands();
std::vector<Command> identity_renew_commands();
std::vector<Command> identity_revoke_commands();
std::vector<Command> ocsp_commands();  ///< the command identity ocsp
std::vector<Command> crl_commands();
std::vector<Command> document_commands();  ///< sign and verify of governance, permissions
std::vector<Command> show_commands();      ///< show of governance, permissions
std::vector<Command> ros_policy_commands();
std::vector<Command> lint_commands();  ///< lint of governance, permissions
std::vector<Command> diff_commands();  ///< diff of governance, permissions
std::vector<Command> keystore_commands();
std::vector<Command> keystore_ca_commands();  ///< the commands keystore split-ca, rotate
std::vector<Command> can_commands();
std::vector<Command> check_commands();
std::vector<Command> expiry_commands();
std::vector<Command> agent_commands();
std::vector<Command> trust_commands();
std::vector<Command> doctor_commands();
std::vector<Command> inspect_commands();
std::vector<Command> explain_commands();
std::vector<Command> completion_commands();  ///< the commands completion, man
std::vector<Command> version_commands();

}  // namespace ddssec::cli
