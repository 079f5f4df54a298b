#include "cli/ca/new_document.hpp"

#include <filesystem>
#include <system_error>

#include "cli/ca/ca_folder.hpp"
#include "cli/ca/governance_revision.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/file_transaction.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

}  // namespace

Result<std::vector<WrittenFile>> write_document(const std::string& xml, const Arguments& arguments,
                                                const Context& context,
                                                const governance::Governance* governance) {
  fs::path plain = arguments.text("-o");
  std::vector<WrittenFile> out;
  if (!arguments.has("--sign")) {
    DDSSEC_ASSIGN_OR_RETURN(auto written, write_result(plain, as_bytes(xml), arguments));
    out.push_back(std::move(written));
    return out;
  }
  if (plain.extension() == ".p7s") plain.replace_extension("xml");
  if (!arguments.has("--ca"))
    return fail(Code::usage, {.field = "--sign", .note = "it needs --ca DIR"});
  DDSSEC_ASSIGN_OR_RETURN(const auto ca, CaOpener(arguments).open("permissions"));
  NumberedText text{to_bytes(as_bytes(xml))};
  if (governance != nullptr && !arguments.has("--no-revision")) {
    DDSSEC_ASSIGN_OR_RETURN(text,
                            with_next_revision(*governance, text.octets, signed_path(plain), ca));
  }
  DDSSEC_ASSIGN_OR_RETURN(
      const auto signature,
      ca.authority.sign_document(text.octets, context.clock.calendar_seconds(), context.random));
  for (const auto& file : {plain, signed_path(plain)})
    DDSSEC_RETURN_IF_ERROR(check_result_place(file, arguments));
  DDSSEC_RETURN_IF_ERROR(log_signed(
      ca.paths,
      signed_line(ca.certificate(), text, signed_path(plain), context.clock.calendar_seconds())));
  if (arguments.has("--replace")) {
    FileTransaction both;
    DDSSEC_RETURN_IF_ERROR(both.put_public(plain, xml));
    DDSSEC_RETURN_IF_ERROR(both.put(signed_path(plain), signature, 0644));
    return both.commit();
  }
  DDSSEC_ASSIGN_OR_RETURN(auto written, write_result(plain, as_bytes(xml), arguments));
  out.push_back(std::move(written));
  auto second = write_result(signed_path(plain), signature, arguments);
  if (!second) {
    std::error_code ignored;
    fs::remove(plain, ignored);
    return std::unexpected(second.error());
  }
  out.push_back(*std::move(second));
  return out;
}

}  // namespace ddssec::cli
