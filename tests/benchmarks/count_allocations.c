// SPDX-License-Identifier: BSD-3-Clause
// A library that the loader puts before the C library (LD_PRELOAD): it counts the calls that give memory, and at the
// end of the process appends "name count" to the file that PLSLAM_ALLOCATIONS names. For scripts/benchmark.
#define _GNU_SOURCE
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* __libc_memalign(size_t alignment, size_t size);

static atomic_long calls;

static void Count(void) { atomic_fetch_add_explicit(&calls, 1, memory_order_relaxed); }

void* malloc(size_t size) {
  Count();
  return __libc_malloc(size);
}

void* calloc(size_t count, size_t size) {
  Count();
  return __libc_calloc(count, size);
}

void* realloc(void* old, size_t size) {
  Count();
  return __libc_realloc(old, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
  Count();
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** out, size_t alignment, size_t size) {
  Count();
  void* const memory = __libc_memalign(alignment, size);
  if (memory == NULL) return ENOMEM;
  *out = memory;
  return 0;
}

__attribute__((destructor)) static void Report(void) {
  const char* path = getenv("PLSLAM_ALLOCATIONS");
  if (path == NULL) return;
  const long n = atomic_load(&calls);
  FILE* file = fopen(path, "a");
  if (file == NULL) return;
  fprintf(file, "%s %ld\n", program_invocation_short_name, n);
  fclose(file);
}
