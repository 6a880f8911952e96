# Toolchain for 64-bit ARM under Linux: Debian's cross compiler, libraries of the architecture arm64 beside those of the
# machine (dpkg --add-architecture arm64), programs run by qemu-user. -DCMAKE_TOOLCHAIN_FILE=src/cmake/aarch64-linux-gnu.cmake
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64)
# pkg-config alone knows no architecture: it is given the folders of this one, and those that belong to none.
set(ENV{PKG_CONFIG_LIBDIR} /usr/lib/aarch64-linux-gnu/pkgconfig:/usr/share/pkgconfig)
# CMake packages of the machine's own libraries would be found, too, and linked in vain.
set(CMAKE_IGNORE_PREFIX_PATH /usr/lib/x86_64-linux-gnu)
