# What `cmake --install` puts where, as four components: runtime (the shared library), development (header, CMake
# package, pkg-config file, static library), tools (bcc4) and python.
include(CMakePackageConfigHelpers)
set(BCCSPLAT_REQUIRES_PRIVATE zlib libhwy)
if(BCCSPLAT_WITH_LIBDEFLATE)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(BCCSPLAT_DEFLATE QUIET libdeflate)
  if(BCCSPLAT_DEFLATE_FOUND)
    list(APPEND BCCSPLAT_REQUIRES_PRIVATE libdeflate)
  endif()
endif()
if(BCCSPLAT_HAS_GPU)
  list(APPEND BCCSPLAT_REQUIRES_PRIVATE epoxy)
endif()
if(BCCSPLAT_WITH_IMAGE)
  list(APPEND BCCSPLAT_REQUIRES_PRIVATE OpenEXR libpng)
endif()
list(JOIN BCCSPLAT_REQUIRES_PRIVATE " " BCCSPLAT_REQUIRES_PRIVATE)

if(TARGET bccsplat)
  set(BCCSPLAT_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/bccsplat)
  install(TARGETS bccsplat EXPORT bccsplatTargets
    RUNTIME COMPONENT runtime ARCHIVE COMPONENT development
    LIBRARY COMPONENT runtime NAMELINK_COMPONENT development)
  if(WIN32) # for MSVC; MinGW's is the archive above
    install(FILES ${PROJECT_BINARY_DIR}/src/bccsplat.lib DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
  endif()
  if(TARGET bccsplat_static)
    install(TARGETS bccsplat_static EXPORT bccsplatTargets ARCHIVE COMPONENT development)
  endif()
  install(FILES include/bccsplat.h include/bccsplat.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  install(EXPORT bccsplatTargets NAMESPACE bccsplat:: DESTINATION ${BCCSPLAT_PACKAGE_DIR} COMPONENT development)
  configure_package_config_file(src/cmake/bccsplatConfig.cmake.in ${PROJECT_BINARY_DIR}/bccsplatConfig.cmake
    INSTALL_DESTINATION ${BCCSPLAT_PACKAGE_DIR})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/bccsplatConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/bccsplatConfig.cmake ${PROJECT_BINARY_DIR}/bccsplatConfigVersion.cmake
    DESTINATION ${BCCSPLAT_PACKAGE_DIR} COMPONENT development)
  file(RELATIVE_PATH BCCSPLAT_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  configure_file(src/cmake/bccsplat.pc.in ${PROJECT_BINARY_DIR}/bccsplat.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/bccsplat.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
    COMPONENT development)

  # A wheel's layout, without compilation; the package finds the library from its own place.
  set(BCCSPLAT_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Where Python packages go, below the prefix")
  install(DIRECTORY examples/python/bccsplat DESTINATION ${BCCSPLAT_PYTHON_DIR} COMPONENT python
    FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
  file(RELATIVE_PATH lib_from_python ${CMAKE_INSTALL_PREFIX}/${BCCSPLAT_PYTHON_DIR}/bccsplat ${CMAKE_INSTALL_FULL_LIBDIR})
  file(WRITE ${PROJECT_BINARY_DIR}/python/library_path "${lib_from_python}\n")
  install(FILES ${PROJECT_BINARY_DIR}/python/library_path DESTINATION ${BCCSPLAT_PYTHON_DIR}/bccsplat
    COMPONENT python)
  configure_file(src/cmake/python_metadata.in ${PROJECT_BINARY_DIR}/python/METADATA @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/python/METADATA
    DESTINATION ${BCCSPLAT_PYTHON_DIR}/bccsplat-${PROJECT_VERSION}.dist-info COMPONENT python)
  install(FILES src/cmake/python_entry_points.txt RENAME entry_points.txt
    DESTINATION ${BCCSPLAT_PYTHON_DIR}/bccsplat-${PROJECT_VERSION}.dist-info COMPONENT python)
endif()

if(TARGET bcc4)
  # The viewer for browsers, where examples/web/build.sh has made it; `bcc4 view` finds it from its own place.
  install(DIRECTORY build-web/site/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bccsplat/web COMPONENT tools OPTIONAL)
  # The installed tool finds the library beside itself, wherever the prefix is moved.
  file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(bcc4 PROPERTIES INSTALL_RPATH $ORIGIN/${lib_from_bin})
  install(TARGETS bcc4 RUNTIME COMPONENT tools)
  foreach(module bcc4_openvdb_module bcc4_netcdf_module bcc4_tiff_module bcc4_microhttpd_module)
    if(TARGET ${module})
      install(TARGETS ${module} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/bccsplat COMPONENT tools)
    endif()
  endforeach()
endif()
