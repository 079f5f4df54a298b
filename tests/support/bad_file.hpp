// What can stand in the place of a document and is none, and a folder that cannot be entered.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

namespace ddssec::test {

inline constexpr std::array<std::string_view, 8> kBadFiles = {
    "Directory", "Socket", "Fifo", "Empty", "Unreadable", "DanglingLink", "TooLarge", "Broken"};

/// Puts such a file into a document's place, and removes it at the end. The document is lost. While
/// an unreadable one lives, the process is another user if it was root, because root can read all
/// files.
class BadFile {
 public:
  BadFile(std::string_view kind, std::filesystem::path path) : path_(std::move(path)) {
    std::filesystem::remove_all(path_);
    if (kind == "Directory") {
      std::filesystem::create_directory(path_);
    } else if (kind == "Socket") {
      bind_socket();
    } else if (kind == "Fifo") {
      ::mkfifo(path_.c_str(), 0600);
    } else if (kind == "DanglingLink") {
      std::filesystem::create_symlink("nowhere", path_);
    } else {
      std::ofstream(path_) << (kind == "Empty" ? "" : "-----BEGIN nonsense");
    }
    // More than is read of any document, and without a block on the disk.
    if (kind == "TooLarge") std::filesystem::resize_file(path_, std::uintmax_t{64} << 20);
    if (kind == "Unreadable") make_unreadable();
  }
  ~BadFile() {
    if (was_root_) (void)!::seteuid(0);
    if (socket_ >= 0) ::close(socket_);
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  BadFile(const BadFile&) = delete;
  BadFile& operator=(const BadFile&) = delete;

 private:
  void bind_socket() {
    socket_ = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    (void)!::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  void make_unreadable() {
    ::chmod(path_.c_str(), 0);
    ::chmod(path_.parent_path().c_str(), 0755);
    was_root_ = ::geteuid() == 0 && ::seteuid(65534) == 0;
  }

  const std::filesystem::path path_;
  int socket_ = -1;
  bool was_root_ = false;
};

/// While this object lives, the process cannot enter the folder. It is another user if it was root,
/// because root can enter all folders.
class ClosedFolder {
 public:
  explicit ClosedFolder(std::filesystem::path path) : path_(std::move(path)) {
    ::chmod(path_.c_str(), 0);
    was_root_ = ::geteuid() == 0 && ::seteuid(65534) == 0;
  }
  ~ClosedFolder() {
    if (was_root_) (void)!::seteuid(0);
    ::chmod(path_.c_str(), 0700);
  }
  ClosedFolder(const ClosedFolder&) = delete;
  ClosedFolder& operator=(const ClosedFolder&) = delete;

 private:
  const std::filesystem::path path_;
  bool was_root_ = false;
};

}  // namespace ddssec::test
