// The measuring peer on two blocking UDP sockets and nothing else, which is the lower bound for the
// roles ping and pong. It sends the payload after 16 octets of header.
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "bench/participants.h"

enum { FIRST_PORT = 29000, MOST = 65000, HEADER = 16 };

struct udp {
  int socket;
  struct sockaddr_in to;
  bool is_ping, has_received;
  uint8_t out[MOST], in[MOST];
  ssize_t received;
};

static uint32_t matched(void* self) {
  const struct udp* udp = self;
  return udp->is_ping || udp->has_received;
}

static bool write_blob(void* self, const struct bench_blob* blob) {
  struct udp* udp = self;
  memcpy(udp->out, blob, HEADER);  // seq, pad and t_ns
  memcpy(udp->out + HEADER, blob->data, blob->length);
  const size_t size = HEADER + (size_t)blob->length;
  return sendto(udp->socket, udp->out, size, 0, (struct sockaddr*)&udp->to, sizeof udp->to) ==
         (ssize_t)size;
}

// Blocks for up to 20 ms, the timeout of the socket.
static void wait_for_data(void* self) {
  struct udp* udp = self;
  udp->received = recv(udp->socket, udp->in, sizeof udp->in, 0);
  udp->has_received = udp->has_received || udp->received >= HEADER;
}

static bool take_blob(void* self, struct bench_blob* blob) {
  struct udp* udp = self;
  if (udp->received < HEADER) return false;
  memcpy(blob, udp->in, HEADER);
  blob->data = udp->in + HEADER;
  blob->length = (uint32_t)(udp->received - HEADER);
  udp->received = 0;
  return true;
}

static bool acknowledged(void* self) {
  (void)self;
  return true;
}

int main(int argc, char** argv) {
  struct bench_options options;
  bench_parse(argc, argv, &options);
  const bool is_ping = options.role == BENCH_PING;
  if ((!is_ping && options.role != BENCH_PONG) || options.listener ||
      options.size > MOST - HEADER) {
    fputs("bench_udp_peer: has the roles ping and pong alone, and no listener\n", stderr);
    return BENCH_USAGE;
  }
  options.waiting = true;
  static struct udp udp;
  udp.is_ping = is_ping;
  udp.socket = socket(AF_INET, SOCK_DGRAM, 0);
  const uint16_t port = (uint16_t)(FIRST_PORT + 2 * options.domain);
  struct sockaddr_in own = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
  udp.to = own;
  own.sin_port = htons(is_ping ? port : port + 1);
  udp.to.sin_port = htons(is_ping ? port + 1 : port);
  const struct timeval timeout = {.tv_usec = 20000};
  setsockopt(udp.socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
  if (udp.socket < 0 || bind(udp.socket, (struct sockaddr*)&own, sizeof own) != 0)
    return bench_refused("socket", "bind failed");
  const struct bench_stack stack = {&udp,      matched,       matched,     write_blob,
                                    take_blob, wait_for_data, acknowledged};
  const int code = bench_run(&options, &stack);
  close(udp.socket);
  return code;
}
