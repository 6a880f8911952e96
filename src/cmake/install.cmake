# What `cmake --install` puts where: library, header, tool, CMake package and pkg-config file.
include(CMakePackageConfigHelpers)

if(TARGET bccsplat)
  set(BCCSPLAT_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/bccsplat)
  install(TARGETS bccsplat EXPORT bccsplatTargets)
  install(FILES include/bccsplat.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
  install(EXPORT bccsplatTargets NAMESPACE bccsplat:: DESTINATION ${BCCSPLAT_PACKAGE_DIR})
  configure_package_config_file(src/cmake/bccsplatConfig.cmake.in ${PROJECT_BINARY_DIR}/bccsplatConfig.cmake
    INSTALL_DESTINATION ${BCCSPLAT_PACKAGE_DIR})
  write_basic_package_version_file(${PROJECT_BINARY_DIR}/bccsplatConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_BINARY_DIR}/bccsplatConfig.cmake ${PROJECT_BINARY_DIR}/bccsplatConfigVersion.cmake
    DESTINATION ${BCCSPLAT_PACKAGE_DIR})
  file(RELATIVE_PATH BCCSPLAT_PC_PREFIX ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  configure_file(src/cmake/bccsplat.pc.in ${PROJECT_BINARY_DIR}/bccsplat.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/bccsplat.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endif()

if(TARGET bcc4)
  # The installed tool finds the library beside itself, wherever the prefix is moved.
  file(RELATIVE_PATH lib_from_bin ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(bcc4 PROPERTIES INSTALL_RPATH $ORIGIN/${lib_from_bin})
  install(TARGETS bcc4)
endif()
