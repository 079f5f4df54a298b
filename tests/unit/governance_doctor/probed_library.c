/* A library that plugin_probe_test.cpp loads. */
#include <stdlib.h>

__attribute__((visibility("default"))) int init_crypto(void);
__attribute__((visibility("default"))) int finalize_crypto(void);
int init_crypto(void) { return 0; }
int finalize_crypto(void) { return 0; }

#ifdef PROBED_crashing
__attribute__((constructor)) static void crash(void) { abort(); }
#endif
