/* SPDX-License-Identifier: Apache-2.0 */
/* What needs no object: versions, names, texts. */
#include "host.h"

#include <pthread.h>

static void* fail_elsewhere(void* seen) {
  *(int*)seen = strlen(bccsplat_last_error()) == 0; /* another thread's text is not ours */
  REFUSED(INVALID_ARGUMENT, "renderer is NULL", bccsplat_renderer_cancel(NULL));
  return NULL;
}

void test_library(void) {
  char before[1100];
  pthread_t thread;
  int32_t status;
  uint32_t kernels = 0;
  int empty_at_first = 0, names = 0;

  EXPECT(bccsplat_version() ==
         BCCSPLAT_VERSION_MAJOR * 10000 + BCCSPLAT_VERSION_MINOR * 100 + BCCSPLAT_VERSION_PATCH);
  EXPECT(bccsplat_abi_version() == BCCSPLAT_ABI_VERSION);
  EXPECT(strstr(bccsplat_build_info(), "version=") == bccsplat_build_info());
  EXPECT(strstr(bccsplat_build_info(), "; simd="));

  for (status = -1; status < 100; ++status) {
    const char* name = bccsplat_status_name(status);
    EXPECT(name && strstr(name, "BCCSPLAT_") == name);
    if (strcmp(name, "BCCSPLAT_UNKNOWN_STATUS") != 0) ++names;
  }
  EXPECT(names == 28);
  EXPECT(strcmp(bccsplat_status_name(BCCSPLAT_ERROR_HOLE), "BCCSPLAT_ERROR_HOLE") == 0);

  while (bccsplat_kernel_name(kernels)) ++kernels;
  EXPECT(kernels > 1 && strcmp(bccsplat_kernel_name(0), "default") == 0);
  EXPECT(!bccsplat_kernel_name(UINT32_MAX));

  EXPECT(strcmp(bccsplat_last_error(), "") == 0); /* nothing failed yet */
  REFUSED(INVALID_ARGUMENT, "volume is NULL", bccsplat_volume_get_info(NULL, NULL));
  strcpy(before, bccsplat_last_error());
  pthread_create(&thread, NULL, fail_elsewhere, &empty_at_first);
  pthread_join(thread, NULL);
  EXPECT(empty_at_first);
  EXPECT(strcmp(bccsplat_last_error(), before) == 0);
}
