/* One secured (or not) participant with a writer and a reader. Waits until it is matched with all the
 * others, says how long that took and what it cost, and stays until its standard input closes. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "Bench.h"
#include "dds/dds.h"

static double seconds_since(const struct timespec* start) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)(now.tv_sec - start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

static double cpu_seconds(void) {
  struct rusage used;
  getrusage(RUSAGE_SELF, &used);
  return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

int main(int argc, char** argv) {
  if (argc != 3) {
    fprintf(stderr, "usage: %s PROCESSES SECONDS\n", argv[0]);
    return 2;
  }
  const uint32_t wanted = (uint32_t)atoi(argv[1]);
  const double limit = atof(argv[2]);
  struct timespec start;
  clock_gettime(CLOCK_MONOTONIC, &start);

  const dds_entity_t participant = dds_create_participant(0, NULL, NULL);
  if (participant < 0) {
    printf("refused %s\n", dds_strretcode(-participant));
    return 3;
  }
  const double created = seconds_since(&start);
  const dds_entity_t topic = dds_create_topic(participant, &Bench_Sample_desc, "Matched", NULL, NULL);
  const dds_entity_t writer = dds_create_writer(participant, topic, NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, topic, NULL, NULL);
  if (topic < 0 || writer < 0 || reader < 0) return 3;

  dds_publication_matched_status_t readers = {0};
  dds_subscription_matched_status_t writers = {0};
  do {
    dds_sleepfor(DDS_MSECS(2));
    dds_get_publication_matched_status(writer, &readers);
    dds_get_subscription_matched_status(reader, &writers);
  } while ((readers.current_count < wanted || writers.current_count < wanted) &&
           seconds_since(&start) < limit);
  const int complete = readers.current_count >= wanted && writers.current_count >= wanted;
  printf("%s %u %u %.4f %.4f %.4f\n", complete ? "matched" : "incomplete", readers.current_count,
         writers.current_count, seconds_since(&start), cpu_seconds(), created);
  fflush(stdout);
  char byte;
  while (read(0, &byte, 1) > 0) continue;
  printf("cpu %.4f\n", cpu_seconds());
  fflush(stdout);
  _exit(complete ? 0 : 1); /* leaving at once: the others' time is what is measured */
}
