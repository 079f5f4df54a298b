// Which subfolders the dynamic loader of this machine searches before each folder.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// Those of this machine's processor and glibc, in their order: glibc-hwcaps/x86-64-v3 and so on,
/// before glibc 2.37 also tls/ and those of the platform. The loader itself is asked: by
/// LD_DEBUG=libs it names the folders that it searches; no program runs. None if it does not
/// answer. Asked once in a process.
const std::vector<std::string>& loader_subfolders();

/// The subfolders of `folder` that a line of LD_DEBUG=libs names, in their order; none if the line
/// is about something else.
std::vector<std::string> subfolders_in(std::string_view line, std::string_view folder);

}  // namespace ddssec::governance::doctor
