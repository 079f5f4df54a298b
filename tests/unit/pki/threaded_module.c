// A PKCS#11 module that starts a thread of its own and then says that it cannot be used. Modules of
// smart cards start threads, too: OpenSC 0.26 does so through GLib.
#include <pthread.h>
#include <signal.h>

// The number of SIGINT and SIGTERM that the thread would handle; -1 if it never ran.
int handled_signals = -1;

static void* count(void* unused) {
  sigset_t blocked;
  pthread_sigmask(SIG_BLOCK, 0, &blocked);
  handled_signals = !sigismember(&blocked, SIGINT) + !sigismember(&blocked, SIGTERM);
  return unused;
}

unsigned long C_GetFunctionList(void** list) {
  pthread_t thread;
  (void)list;
  if (pthread_create(&thread, 0, count, 0) == 0) pthread_join(thread, 0);
  return 5;  // CKR_GENERAL_ERROR
}
