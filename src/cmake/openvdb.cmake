# Finds OpenVDB and defines bccsplat::openvdb. Debian ships no CMake package for it, only a find module that asks for
# Boost and more than a client of the library needs.
find_package(TBB CONFIG REQUIRED)
find_package(Imath CONFIG REQUIRED)
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(OPENVDB_LIBRARY openvdb)
if(NOT OPENVDB_INCLUDE_DIR OR NOT OPENVDB_LIBRARY)
  message(FATAL_ERROR "OpenVDB not found: install libopenvdb-dev or configure with -DBCCSPLAT_WITH_OPENVDB=OFF")
endif()
if(NOT TARGET bccsplat::openvdb)
  # SYSTEM: its headers are not clean under our warnings.
  add_library(bccsplat::openvdb INTERFACE IMPORTED)
  target_include_directories(bccsplat::openvdb SYSTEM INTERFACE ${OPENVDB_INCLUDE_DIR})
  # With hidden symbols the types of its templates differ between program and library, and writing a file crashes.
  target_compile_options(bccsplat::openvdb INTERFACE -fvisibility=default -fno-visibility-inlines-hidden)
  target_link_libraries(bccsplat::openvdb INTERFACE ${OPENVDB_LIBRARY} TBB::tbb Imath::Imath)
endif()
