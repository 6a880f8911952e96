/* SPDX-License-Identifier: Apache-2.0 */
/* A small host: is the library that was found the one the header belongs to, and does it work? */
#include <bccsplat.h>
#include <stdio.h>
#include <string.h>

int main(void) {
  const int version = BCCSPLAT_VERSION_MAJOR * 10000 + BCCSPLAT_VERSION_MINOR * 100 + BCCSPLAT_VERSION_PATCH;
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  int works = bccsplat_version() == version && bccsplat_abi_version() == BCCSPLAT_ABI_VERSION;
  printf("%s\n", bccsplat_build_info());
  works = works && bccsplat_device_create(NULL, &device) == BCCSPLAT_OK;
  works = works && bccsplat_volume_open_memory(device, "text", 4, NULL, &volume) == BCCSPLAT_ERROR_NOT_BCC4 &&
          strlen(bccsplat_last_error()) > 0; /* an exception inside, a status outside */
  bccsplat_device_release(device);
  return works ? 0 : 1;
}
