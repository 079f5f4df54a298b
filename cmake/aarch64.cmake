# Builds for aarch64 with Debian's cross compiler, and runs what is built by qemu:
#   cmake -DCMAKE_TOOLCHAIN_FILE=cmake/aarch64.cmake -DDDSSEC_SYSROOT=FOLDER ...
# FOLDER has the libraries of that architecture (scripts/cross.sh fetches them).
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES DDSSEC_SYSROOT)

set(CMAKE_SYSROOT ${DDSSEC_SYSROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-aarch64-static -L ${DDSSEC_SYSROOT})

set(ENV{PKG_CONFIG_SYSROOT_DIR} ${DDSSEC_SYSROOT})
set(ENV{PKG_CONFIG_LIBDIR}
    ${DDSSEC_SYSROOT}/usr/lib/aarch64-linux-gnu/pkgconfig:${DDSSEC_SYSROOT}/usr/share/pkgconfig)
