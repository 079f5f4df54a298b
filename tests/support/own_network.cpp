// Gives the program that links it a network of its own, before main: a loopback interface with
// multicast and nothing else. Two runs of a test, in one checkout or in two, do not hear each
// other. Where the system does not let it, the program says so and stays in the host's network.
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iostream>
#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <sched.h>
#include <string>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace {

bool write_to(const char* path, const std::string& text) {
  std::ofstream file(path);
  return static_cast<bool>(file << text << std::flush);
}

// Enters a network of its own without root: in a user namespace, whose one user is the same
// outside.
bool unshare_as_user() {
  const auto uid = std::to_string(::geteuid()), gid = std::to_string(::getegid());
  return ::unshare(CLONE_NEWUSER | CLONE_NEWNET) == 0 && write_to("/proc/self/setgroups", "deny") &&
         write_to("/proc/self/uid_map", uid + " " + uid + " 1") &&
         write_to("/proc/self/gid_map", gid + " " + gid + " 1");
}

sockaddr address(in_addr_t host_order) {
  sockaddr_in in{};
  in.sin_family = AF_INET;
  in.sin_addr.s_addr = htonl(host_order);
  sockaddr out{};
  std::memcpy(&out, &in, sizeof in);
  return out;
}

bool bring_up(int socket) {
  ifreq loopback{};
  std::strcpy(loopback.ifr_name, "lo");
  loopback.ifr_flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK | IFF_MULTICAST;
  rtentry multicast{};
  multicast.rt_dst = address(0xe0000000);
  multicast.rt_genmask = address(0xf0000000);
  multicast.rt_flags = RTF_UP;
  multicast.rt_dev = loopback.ifr_name;
  return ::ioctl(socket, SIOCSIFFLAGS, &loopback) == 0 &&
         ::ioctl(socket, SIOCADDRT, &multicast) == 0;
}

void complain(const char* what) {
  const int why = errno;
  std::ios_base::Init init;  // this runs before other constructors
  std::cerr << what << ": " << std::strerror(why) << '\n';
}

// This never ends the program, because the program also runs while it is built, to list its tests.
[[gnu::constructor]] void enter() {
  if (::unshare(CLONE_NEWNET) != 0 && !unshare_as_user())
    return complain("in the host's network, where other runs are heard");
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0 || !bring_up(socket)) complain("the loopback interface does not come up");
  if (socket >= 0) ::close(socket);
}

}  // namespace
