/* SPDX-License-Identifier: Apache-2.0 */
/* load_host LIBRARY FILE TIMES: a host of Windows that loads the library by its name at run time, reads a
 * file by it, and unloads it, so many times. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <windows.h>

#include <shellapi.h>

#include "bccsplat.h"

enum { longest = 1024 };

static void* function_of(HMODULE library, const char* name) {
  const FARPROC found = GetProcAddress(library, name);
  void* as_pointer = NULL;
  if (!found) {
    printf("no function %s\n", name);
    exit(1);
  }
  memcpy(&as_pointer, &found, sizeof as_pointer);
  return as_pointer;
}

#define FUNCTION(library, name)                                                                              \
  do {                                                                                                       \
    void* const found = function_of(library, #name);                                                         \
    memcpy(&(name##_), &found, sizeof found);                                                                \
  } while (0)

static int read_once(HMODULE library, const char* path) {
  bccsplat_status (*bccsplat_device_create_)(const bccsplat_device_options*, bccsplat_device**) = NULL;
  void (*bccsplat_device_release_)(bccsplat_device*) = NULL;
  bccsplat_status (*bccsplat_volume_open_file_)(bccsplat_device*, const char*, const bccsplat_volume_options*,
                                                bccsplat_volume**) = NULL;
  bccsplat_status (*bccsplat_volume_get_info_)(const bccsplat_volume*, bccsplat_volume_info*) = NULL;
  void (*bccsplat_volume_release_)(bccsplat_volume*) = NULL;
  const char* (*bccsplat_last_error_)(void) = NULL;
  bccsplat_device* device = NULL;
  bccsplat_volume* volume = NULL;
  bccsplat_volume_info info = {0};
  int good;
  info.struct_size = sizeof info;
  FUNCTION(library, bccsplat_device_create);
  FUNCTION(library, bccsplat_device_release);
  FUNCTION(library, bccsplat_volume_open_file);
  FUNCTION(library, bccsplat_volume_get_info);
  FUNCTION(library, bccsplat_volume_release);
  FUNCTION(library, bccsplat_last_error);
  good = bccsplat_device_create_(NULL, &device) == BCCSPLAT_OK &&
         bccsplat_volume_open_file_(device, path, NULL, &volume) == BCCSPLAT_OK &&
         bccsplat_volume_get_info_(volume, &info) == BCCSPLAT_OK && info.dims[0] > 0;
  if (!good) printf("%s: %s\n", path, bccsplat_last_error_());
  bccsplat_volume_release_(volume);
  bccsplat_device_release_(device);
  return good;
}

static unsigned long handles(void) {
  DWORD count = 0;
  GetProcessHandleCount(GetCurrentProcess(), &count);
  return count;
}

int main(void) {
  int count = 0, i, times;
  wchar_t** words = CommandLineToArgvW(GetCommandLineW(), &count);
  char path[longest] = {0};
  unsigned long before = 0;
  if (!words || count != 4) return 2;
  WideCharToMultiByte(CP_UTF8, 0, words[2], -1, path, sizeof path, NULL, NULL);
  times = (int)wcstol(words[3], NULL, 10);
  for (i = 0; i < times; ++i) {
    const HMODULE library = LoadLibraryW(words[1]);
    if (!library) {
      printf("the library cannot be loaded: error %lu\n", GetLastError());
      return 1;
    }
    if (!read_once(library, path)) return 1;
    if (!FreeLibrary(library) || GetModuleHandleW(words[1])) {
      printf("the library stays loaded\n");
      return 1;
    }
    if (i == 1) before = handles();
  }
  if (times > 2 && handles() > before + 2) {
    printf("%lu handles became %lu\n", before, handles());
    return 1;
  }
  printf("loaded and unloaded %d times\n", times);
  LocalFree(words);
  return 0;
}
