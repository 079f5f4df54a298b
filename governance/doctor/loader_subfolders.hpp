// Finds the subfolders that this machine's dynamic loader searches before each folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// Returns the subfolders for this machine's processor and glibc, in order: glibc-hwcaps/x86-64-v3
/// and so on; before glibc 2.37 also tls/ and those of the platform. The loader itself provides
/// them: with LD_DEBUG=libs it lists the folders that it searches, without running a program. Empty
/// if it does not answer. Determined once per process.
const std::vector<std::string>& loader_subfolders();

/// Returns the subfolders of `folder` in a line of LD_DEBUG=libs, in order; empty if the line is
/// about something else.
std::vector<std::string> subfolders_in(std::string_view line, std::string_view folder);

}  // namespace ddssec::governance::doctor
