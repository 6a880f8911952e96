# The core for browsers: WebAssembly with vectors of 128 bits and its own exceptions, without threads and libraries of the
# system. Highway is used as headers alone: there is one instruction set.
find_path(BCCSPLAT_HWY_INCLUDE hwy/highway.h REQUIRED)
add_library(bccsplat_hwy INTERFACE)
target_include_directories(bccsplat_hwy SYSTEM INTERFACE ${BCCSPLAT_HWY_INCLUDE})
target_compile_definitions(bccsplat_hwy INTERFACE HWY_COMPILE_ONLY_STATIC)
target_compile_options(bccsplat_hwy INTERFACE -msimd128 -fwasm-exceptions -fno-rtti
  -include ${CMAKE_CURRENT_SOURCE_DIR}/base/libcxx13.h)
target_link_options(bccsplat_hwy INTERFACE -fwasm-exceptions)
add_library(PkgConfig::HWY ALIAS bccsplat_hwy)

# Debian 12's Highway has no vectors of doubles for WebAssembly: loops that take them are compiled without.
set(loops_of_doubles src/field/footprint/footprint.cpp src/field/point_axes.cpp formats/bcc4/coding/find_codes.cpp
  formats/bcc4/encode/normal_equations.cpp formats/bcc4/coding/spread.cpp formats/bcc4/encode/tap_rows.cpp)
list(TRANSFORM loops_of_doubles PREPEND ${PROJECT_SOURCE_DIR}/)
set_source_files_properties(${loops_of_doubles} PROPERTIES COMPILE_DEFINITIONS HWY_BASELINE_TARGETS=HWY_SCALAR)

# A module is small where it is compiled for size (-Oz), but for the loops that a moment takes its time in.
set(loops_of_moments src/field/coefficients/stage_plane.cpp src/field/footprint/grid_rows.cpp src/points/rounded_brick.cpp
  src/slice/time_slice.cpp formats/bcc4/coding/unpredict_rows.cpp
  formats/bcc4/coding/range.cpp src/gpu/field_bricks.cpp)
list(TRANSFORM loops_of_moments PREPEND ${PROJECT_SOURCE_DIR}/)
set_source_files_properties(${loops_of_moments} PROPERTIES COMPILE_OPTIONS -O2)

# The body of the shader goes into the module without its comments.
set(march_body ${CMAKE_CURRENT_SOURCE_DIR}/gpu/march.glsl.inc)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${march_body})
file(READ ${march_body} march_text)
string(REGEX REPLACE "[ \t]*//[^\n]*" "" march_text "${march_text}")
string(REGEX REPLACE "\n[ \n\t]+" "\n" march_text "${march_text}")
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/short/gpu/march.glsl.inc CONTENT "${march_text}" @ONLY)
set(core_first ${CMAKE_CURRENT_BINARY_DIR}/short)
