#include "rtps/memory/memory_refusal.hpp"

namespace ddssec::rtps::memory {

bool may_pass_by(MemoryRefusal why) {
  using enum MemoryRefusal;
  return why == not_matched || why == no_answer || why == no_socket || why == too_many_tokens ||
         why == other_segment || why == held_up;
}

std::string_view to_string(MemoryRefusal why) {
  switch (why) {
    case MemoryRefusal::no_memory:
      return "the system gave no memory, descriptor or mapping";
    case MemoryRefusal::no_seals:
      return "the kernel cannot seal memory against writing (Linux before 5.1)";
    case MemoryRefusal::bad_shape:
      return "the samples are too large for shared memory";
    case MemoryRefusal::too_large:
      return "a payload does not fit";
    case MemoryRefusal::full:
      return "readers still need all of the memory";
    case MemoryRefusal::wrong_kind:
      return "the descriptor is not of memory that can be sealed";
    case MemoryRefusal::not_sealed:
      return "the memory is not sealed";
    case MemoryRefusal::wrong_size:
      return "the memory is empty, too large or not all there";
    case MemoryRefusal::other_memory:
      return "another memory than the one offered was passed on";
    case MemoryRefusal::other_segment:
      return "the memory is not mapped";
    case MemoryRefusal::outside:
      return "a reference leaves the memory";
    case MemoryRefusal::gone:
      return "the payload was replaced";
    case MemoryRefusal::no_socket:
      return "the local socket cannot be made or reached: another network namespace, or no "
             "descriptors are left";
    case MemoryRefusal::wrong_process:
      return "another process than the writer's listens, or the process is in another PID "
             "namespace";
    case MemoryRefusal::no_answer:
      return "there is no answer: the other process has an earlier version, is too slow, or runs "
             "as another user and org.ddssec.shm.other_users is not true in both";
    case MemoryRefusal::too_many_tokens:
      return "too many offers are open";
    case MemoryRefusal::not_matched:
      return "the reader has not matched the writer";
    case MemoryRefusal::limit_reached:
      return "the limit is reached that the property org.ddssec.shm.max_octets sets";
    case MemoryRefusal::other_user:
      return "the processes are of different users: if both are to share memory, set the property "
             "org.ddssec.shm.other_users to true in both";
    case MemoryRefusal::no_room:
      return "the memory limit of the process (cgroup) leaves too little room";
    case MemoryRefusal::held_up:
      return "another process holds up the thread that passes descriptors on";
    case MemoryRefusal::off:
      return "the property org.ddssec.shm is off there: to share memory, set it to on in both";
  }
  return "unknown";
}

}  // namespace ddssec::rtps::memory
