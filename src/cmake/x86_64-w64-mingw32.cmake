# Toolchain for Windows on x86-64: mingw-w64 as Debian has it, programs run by Wine. Libraries are looked for in
# BCCSPLAT_WINDOWS_LIBRARIES, which tests/cross/windows_libraries.sh makes, and where Debian has those for mingw.
# -DCMAKE_TOOLCHAIN_FILE=src/cmake/x86_64-w64-mingw32.cmake
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
set(CMAKE_CROSSCOMPILING_EMULATOR wine)
set(CMAKE_FIND_ROOT_PATH ${BCCSPLAT_WINDOWS_LIBRARIES} /usr/x86_64-w64-mingw32)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
  set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES BCCSPLAT_WINDOWS_LIBRARIES)
set(ENV{PKG_CONFIG_LIBDIR} ${BCCSPLAT_WINDOWS_LIBRARIES}/lib/pkgconfig)
# GCC takes stacks for aligned as AVX wants it, where Windows has 16 bytes (GCC's bug 54412): the assembler writes moves
# that need no alignment.
set(flags "-D_WIN32_WINNT=0x0A00 -DWIN32_LEAN_AND_MEAN -DNOMINMAX -D_USE_MATH_DEFINES -Wa,-muse-unaligned-vector-move")
set(CMAKE_C_FLAGS_INIT ${flags})
set(CMAKE_CXX_FLAGS_INIT ${flags})
# What comes with the compiler is put into each file, so that hosts need no DLL but ours.
foreach(kind EXE SHARED MODULE)
  set(CMAKE_${kind}_LINKER_FLAGS_INIT -static)
endforeach()
set(ZLIB_LIBRARY /usr/x86_64-w64-mingw32/lib/libz.a CACHE FILEPATH "Debian's zlib for mingw, as a static library")
