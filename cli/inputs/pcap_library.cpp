#include "cli/inputs/pcap_library.hpp"

#include <bit>
#include <dlfcn.h>
#include <optional>
#include <string>

namespace ddssec::cli {
namespace {

// Debian's name, and that of libpcap itself.
constexpr const char* kNames[] = {"libpcap.so.0.8", "libpcap.so.1"};

std::unexpected<Error> no_library_error(std::string found) {
  return fail(Code::capture_unreadable,
              {.expected = "libpcap, which reads captures",
               .found = std::move(found),
               .hint = "install libpcap (Debian: apt install libpcap0.8)"});
}

// `found` gets what the loader says of the first name.
void* open_library(std::string& found) {
  for (const char* name : kNames) {
    if (void* const library = ::dlopen(name, RTLD_NOW | RTLD_LOCAL)) return library;
    const char* const why = ::dlerror();
    if (found.empty() && why != nullptr) found = why;
  }
  return nullptr;
}

template <class Function>
bool look_up(void* library, const char* name, Function& function) {
  function = std::bit_cast<Function>(::dlsym(library, name));
  return function != nullptr;
}

bool look_up_all(void* library, PcapLibrary& out) {
  return look_up(library, "pcap_open_offline_with_tstamp_precision",
                 out.open_offline_with_tstamp_precision) &&
         look_up(library, "pcap_create", out.create) &&
         look_up(library, "pcap_set_snaplen", out.set_snaplen) &&
         look_up(library, "pcap_set_timeout", out.set_timeout) &&
         look_up(library, "pcap_set_buffer_size", out.set_buffer_size) &&
         look_up(library, "pcap_set_tstamp_precision", out.set_tstamp_precision) &&
         look_up(library, "pcap_activate", out.activate) &&
         look_up(library, "pcap_setnonblock", out.setnonblock) &&
         look_up(library, "pcap_geterr", out.geterr) &&
         look_up(library, "pcap_datalink", out.datalink) &&
         look_up(library, "pcap_get_selectable_fd", out.selectable_fd) &&
         look_up(library, "pcap_next_ex", out.next_ex) &&
         look_up(library, "pcap_close", out.close) &&
         look_up(library, "pcap_dump_fopen", out.dump_fopen) &&
         look_up(library, "pcap_dump", out.dump) &&
         look_up(library, "pcap_dump_flush", out.dump_flush) &&
         look_up(library, "pcap_dump_close", out.dump_close);
}

}  // namespace

Result<const PcapLibrary*> PcapLibrary::load() {
  static std::optional<PcapLibrary> loaded;
  if (loaded) return &*loaded;
  std::string found;
  void* const library = open_library(found);
  if (library == nullptr) return no_library_error(std::move(found));
  PcapLibrary functions{};
  if (!look_up_all(library, functions)) {
    const char* const why = ::dlerror();
    return no_library_error(why != nullptr ? why : "a library without its functions");
  }
  loaded = functions;
  return &*loaded;
}

}  // namespace ddssec::cli
