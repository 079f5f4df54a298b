#include "cli/inputs/capture.hpp"

#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <limits>
#include <poll.h>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "cli/frame/file_transaction.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/pcap_library.hpp"

namespace ddssec::cli {
namespace {

constexpr unsigned kMode = 0600;  // only the owner may read a capture
constexpr int kSnapshotOctets = 262'144;
constexpr int kWaitMilliseconds = 100;
constexpr int kBufferOctets = 16 << 20;

struct ClosePcap {
  const PcapLibrary* library;
  void operator()(pcap_t* pcap) const noexcept { library->close(pcap); }
};
struct CloseDump {
  const PcapLibrary* library;
  void operator()(pcap_dumper_t* dump) const noexcept { library->dump_close(dump); }
};

std::unexpected<Error> unreadable_capture_error(const std::string& what, std::string note) {
  return fail(Code::capture_unreadable, {.document = what, .note = std::move(note)});
}

}  // namespace

struct Capture::Impl {
  std::string name;
  bool is_live;
  const PcapLibrary* library;
  std::unique_ptr<pcap_t, ClosePcap> pcap;
  std::unique_ptr<pcap_dumper_t, CloseDump> dump = {nullptr, CloseDump{library}};
  std::string file = {};  // the file to which `dump` writes
};

Capture::Capture(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Capture::~Capture() = default;
Capture::Capture(Capture&&) noexcept = default;

Result<Capture> Capture::open(const std::string& file) {
  DDSSEC_ASSIGN_OR_RETURN(const auto* library, PcapLibrary::load());
  char why[PCAP_ERRBUF_SIZE] = {};
  std::unique_ptr<pcap_t, ClosePcap> pcap(
      library->open_offline_with_tstamp_precision(file.c_str(), PCAP_TSTAMP_PRECISION_NANO, why),
      ClosePcap{library});
  if (!pcap) return unreadable_capture_error(file, why);
  return Capture(std::make_unique<Impl>(Impl{file, false, library, std::move(pcap)}));
}

Result<Capture> Capture::listen(const std::string& interface) {
  DDSSEC_ASSIGN_OR_RETURN(const auto* library, PcapLibrary::load());
  char why[PCAP_ERRBUF_SIZE] = {};
  std::unique_ptr<pcap_t, ClosePcap> pcap(library->create(interface.c_str(), why),
                                          ClosePcap{library});
  if (!pcap) return unreadable_capture_error(interface, why);
  library->set_snaplen(pcap.get(), kSnapshotOctets);
  library->set_timeout(pcap.get(), kWaitMilliseconds);
  library->set_buffer_size(pcap.get(), kBufferOctets);
  library->set_tstamp_precision(pcap.get(), PCAP_TSTAMP_PRECISION_NANO);
  if (library->activate(pcap.get()) < 0 || library->setnonblock(pcap.get(), 1, why) < 0)
    return unreadable_capture_error(interface, library->geterr(pcap.get()));
  return Capture(std::make_unique<Impl>(Impl{interface, true, library, std::move(pcap)}));
}

int Capture::link() const { return impl_->library->datalink(impl_->pcap.get()); }

// Refuses to overwrite an existing file.
Status Capture::save_to(const std::string& file) {
  impl_->file = file;
  if (writes_nothing()) return check_nothing_at(file);
  const int number =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, kMode);
  const int error = errno;
  if (number < 0 && error == EEXIST) return fail(Code::would_overwrite, {.document = file});
  auto* stream = number < 0 ? nullptr : ::fdopen(number, "w");
  if (stream == nullptr) return unwritable_error(file, error);
  impl_->dump.reset(impl_->library->dump_fopen(impl_->pcap.get(), stream));
  if (impl_->dump) return {};
  std::fclose(stream);
  return fail(Code::file_unwritable,
              {.document = file, .note = impl_->library->geterr(impl_->pcap.get())});
}

Result<WrittenFile> Capture::saved() {
  WrittenFile out{.path = impl_->file, .mode = fmt::format("{:04o}", kMode)};
  if (!impl_->dump) return out;
  const bool whole = impl_->library->dump_flush(impl_->dump.get()) == 0;
  const int error = errno;
  impl_->dump.reset();
  if (!whole) {
    std::remove(impl_->file.c_str());
    return unwritable_error(impl_->file, error);
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto octets,
                          read_file(impl_->file, std::numeric_limits<std::size_t>::max()));
  out.sha256 = to_hex(sha256(octets));
  return out;
}

Status Capture::each(std::chrono::nanoseconds how_long,
                     const std::function<void(const CapturedFrame&)>& take) {
  using Steady = std::chrono::steady_clock;
  const auto end = Steady::now() + how_long;
  pollfd ready{impl_->library->selectable_fd(impl_->pcap.get()), POLLIN, 0};
  while (check_not_interrupted() && (!impl_->is_live || Steady::now() < end)) {
    pcap_pkthdr* header = nullptr;
    const unsigned char* octets = nullptr;
    const int result = impl_->library->next_ex(impl_->pcap.get(), &header, &octets);
    if (result == PCAP_ERROR_BREAK) break;  // the end of the file
    if (result < 0)
      return unreadable_capture_error(impl_->name, impl_->library->geterr(impl_->pcap.get()));
    if (result == 0) {
      ::poll(&ready, 1, kWaitMilliseconds);
      continue;
    }
    if (impl_->dump)
      impl_->library->dump(static_cast<unsigned char*>(static_cast<void*>(impl_->dump.get())),
                           header, octets);
    // With PCAP_TSTAMP_PRECISION_NANO, tv_usec has nanoseconds.
    take({std::chrono::seconds(header->ts.tv_sec) + std::chrono::nanoseconds(header->ts.tv_usec),
          BytesView(octets, header->caplen), header->caplen == header->len});
  }
  return {};
}

}  // namespace ddssec::cli
