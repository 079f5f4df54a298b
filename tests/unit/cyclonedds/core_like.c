// Exports the function by which Cyclone DDS's core sets the timer of a handshake.
#include <stdint.h>

__attribute__((visibility("default"))) void dds_security_fsm_set_timeout(void* machine,
                                                                         void* action,
                                                                         int64_t timeout) {
  (void)machine, (void)action, (void)timeout;
}
