# Toolchain for 64-bit ARM under Linux: Debian's cross compiler, libraries in BCCSPLAT_AARCH64_ROOT, which
# tests/cross/aarch64_libraries.sh makes, programs run by qemu-user. -DCMAKE_TOOLCHAIN_FILE=src/cmake/aarch64-linux-gnu.cmake
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
# GCC tells of every struct of floats that it hands over as it did not before GCC 7.
set(CMAKE_CXX_FLAGS_INIT -Wno-psabi)
set(CMAKE_SYSROOT ${BCCSPLAT_AARCH64_ROOT})
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64 -L ${BCCSPLAT_AARCH64_ROOT})
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES BCCSPLAT_AARCH64_ROOT)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(ENV{PKG_CONFIG_LIBDIR} ${BCCSPLAT_AARCH64_ROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${BCCSPLAT_AARCH64_ROOT}/usr/lib/pkgconfig)
set(ENV{PKG_CONFIG_SYSROOT_DIR} ${BCCSPLAT_AARCH64_ROOT})
