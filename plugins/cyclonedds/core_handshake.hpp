// The layout of a handshake in Cyclone DDS's core, the same in 0.10.2 and 0.10.5. The core has no
// header for it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <dds/ddsrt/sync.h>

#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {

/// A GUID as the core stores it: four numbers in the byte order of the machine.
using CoreGuid = std::array<std::uint32_t, 4>;
static_assert(sizeof(CoreGuid) == sizeof(DDS_Security_GUID_t));

/// struct dds_security_fsm, to the member that points back to the handshake.
struct CoreStateMachine {
  const void* neighbours[2];
  bool is_being_deleted;
  bool is_busy;
  const void* control;
  const void* transitions;
  std::uint32_t transition_count;
  const void* argument;
};

/// struct ddsi_handshake, to the member whose address validate_remote_identity gets.
struct CoreHandshake {
  struct {
    const void* children[2];
    const void* parent;
    int height;
  } tree;
  int state;
  CoreGuid local, remote;
  std::int64_t handle;
  std::uint32_t references, is_being_deleted;
  const void* end_callback;
  ddsrt_mutex_t lock;
  CoreStateMachine* machine;
  const void* domain;
  const void* plugin;
  DDS_Security_DataHolder message_in;
  CoreGuid message_source;
  std::int64_t message_number;
  const void* message_out;
  DDS_Security_DataHolder local_auth_request;
};
#if defined(__x86_64__)
static_assert(offsetof(CoreHandshake, machine) == 0x88);
static_assert(offsetof(CoreHandshake, local_auth_request) == 0xe8);
static_assert(offsetof(CoreStateMachine, argument) == 0x30);
#endif

}  // namespace ddssec::cyclonedds
