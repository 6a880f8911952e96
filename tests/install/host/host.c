/* The smallest host: is the library that was found the one the header belongs to? */
#include <bccsplat.h>
#include <stdio.h>

int main(void) {
  const int version = BCCSPLAT_VERSION_MAJOR * 10000 + BCCSPLAT_VERSION_MINOR * 100 + BCCSPLAT_VERSION_PATCH;
  printf("%s\n", bccsplat_build_info());
  return bccsplat_version() == version && bccsplat_abi_version() == BCCSPLAT_ABI_VERSION ? 0 : 1;
}
