# The core for browsers: WebAssembly with vectors of 128 bits and its own exceptions, without threads and libraries of the
# system. Highway is used as headers alone: there is one instruction set.
find_path(BCCSPLAT_HWY_INCLUDE hwy/highway.h REQUIRED)
add_library(bccsplat_hwy INTERFACE)
target_include_directories(bccsplat_hwy SYSTEM INTERFACE ${BCCSPLAT_HWY_INCLUDE})
target_compile_definitions(bccsplat_hwy INTERFACE HWY_COMPILE_ONLY_STATIC)
target_compile_options(bccsplat_hwy INTERFACE -msimd128 -fwasm-exceptions -include ${CMAKE_CURRENT_SOURCE_DIR}/base/libcxx13.h)
target_link_options(bccsplat_hwy INTERFACE -fwasm-exceptions)
add_library(PkgConfig::HWY ALIAS bccsplat_hwy)

# Debian 12's Highway has no vectors of doubles for WebAssembly: loops that take them are compiled without.
set(loops_of_doubles src/field/footprint/footprint.cpp src/field/point_axes.cpp formats/bcc4/coding/find_codes.cpp
  formats/bcc4/coding/normal_equations.cpp formats/bcc4/coding/spread.cpp formats/bcc4/coding/tap_rows.cpp)
list(TRANSFORM loops_of_doubles PREPEND ${PROJECT_SOURCE_DIR}/)
set_source_files_properties(${loops_of_doubles} PROPERTIES COMPILE_DEFINITIONS HWY_BASELINE_TARGETS=HWY_SCALAR)

# A module is small where it is compiled for size (-Os), but for the loops that a moment takes its time in.
set(loops_of_moments src/field/coefficients/stage_plane.cpp src/field/footprint/grid_rows.cpp src/points/rounded_brick.cpp
  src/slice/time_slice.cpp formats/bcc4/coding/inflate_literals.cpp formats/bcc4/coding/unpredict_rows.cpp
  formats/bcc4/coding/range.cpp src/gpu/field_bricks.cpp)
list(TRANSFORM loops_of_moments PREPEND ${PROJECT_SOURCE_DIR}/)
set_source_files_properties(${loops_of_moments} PROPERTIES COMPILE_OPTIONS -O2)
