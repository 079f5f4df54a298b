// Preloaded, it makes programs believe that it is ANOTHER_DAY days later (scripts/another_day.sh).
// Only the calendar moves: what measures how long something takes, and the dates of files, stay as
// they are. A wait until a day and time ends when it would without the library.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static time_t seconds_later(void) {
  const char* days = getenv("ANOTHER_DAY");
  return days == NULL ? 0 : atol(days) * 24 * 60 * 60;
}

int clock_gettime(clockid_t clock, struct timespec* now) {
  const int result = (int)syscall(SYS_clock_gettime, clock, now);
  if (result == 0 && (clock == CLOCK_REALTIME || clock == CLOCK_REALTIME_COARSE))
    now->tv_sec += seconds_later();
  return result;
}

time_t time(time_t* copy) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (copy != NULL) *copy = now.tv_sec;
  return now.tv_sec;
}

int gettimeofday(struct timeval* now, void* zone) {
  (void)zone;
  struct timespec exact;
  clock_gettime(CLOCK_REALTIME, &exact);
  now->tv_sec = exact.tv_sec;
  now->tv_usec = exact.tv_nsec / 1000;
  return 0;
}

// A deadline for the kernel's clock. Deadlines of the steady clock, which begins with the machine,
// are below a billion seconds and stay as they are.
static const struct timespec* moved_back(const struct timespec* deadline, struct timespec* copy) {
  if (deadline == NULL || deadline->tv_sec < 1000000000) return deadline;
  *copy = *deadline;
  copy->tv_sec -= seconds_later();
  return copy;
}

// The function that this library hides. There are two of pthread_cond_timedwait, and the older one
// does not know today's conditions.
static void* hidden(const char* name) {
  void* found = dlvsym(RTLD_NEXT, name, "GLIBC_2.3.2");
  return found != NULL ? found : dlsym(RTLD_NEXT, name);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const struct timespec* deadline) {
  static int (*next)(pthread_cond_t*, pthread_mutex_t*, const struct timespec*);
  if (next == NULL) *(void**)&next = hidden("pthread_cond_timedwait");
  struct timespec copy;
  return next(condition, mutex, moved_back(deadline, &copy));
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const struct timespec* deadline) {
  static int (*next)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const struct timespec*);
  if (next == NULL) *(void**)&next = hidden("pthread_cond_clockwait");
  struct timespec copy;
  return next(condition, mutex, clock, moved_back(deadline, &copy));
}

int pthread_mutex_timedlock(pthread_mutex_t* mutex, const struct timespec* deadline) {
  static int (*next)(pthread_mutex_t*, const struct timespec*);
  if (next == NULL) *(void**)&next = hidden("pthread_mutex_timedlock");
  struct timespec copy;
  return next(mutex, moved_back(deadline, &copy));
}

int sem_timedwait(sem_t* semaphore, const struct timespec* deadline) {
  static int (*next)(sem_t*, const struct timespec*);
  if (next == NULL) *(void**)&next = hidden("sem_timedwait");
  struct timespec copy;
  return next(semaphore, moved_back(deadline, &copy));
}
