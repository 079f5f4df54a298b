// Writes a new document and, if the options ask for it, its signed form.
#pragma once

#include <string>
#include <vector>

#include "cli/frame/command.hpp"
#include "governance/model.hpp"

namespace ddssec::cli {

/// Writes a new document to the path of -o and, with --sign, its signed form beside it (-o may name
/// either). Writes both or neither. `governance` is the document itself if it is a governance
/// document. Its signed form has the next revision, unless --no-revision is given. Errors: usage
/// (--sign without --ca), and those of CaOpener, with_next_revision, Authority::sign_document and
/// write_new_file.
Result<std::vector<WrittenFile>> write_document(const std::string& xml, const Arguments& arguments,
                                                const Context& context,
                                                const governance::Governance* governance = nullptr);

}  // namespace ddssec::cli
