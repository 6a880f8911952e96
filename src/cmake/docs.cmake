# `cmake --build . --target docs`: the header, which is the manual, as HTML under docs/html. A warning is an error.
find_package(Doxygen QUIET)
if(DOXYGEN_FOUND)
  configure_file(src/cmake/Doxyfile.in ${PROJECT_BINARY_DIR}/docs/Doxyfile @ONLY)
  add_custom_target(docs COMMAND Doxygen::doxygen Doxyfile WORKING_DIRECTORY ${PROJECT_BINARY_DIR}/docs VERBATIM)
endif()
if(BCCSPLAT_BUILD_TESTS)
  # 77: no doxygen here.
  add_test(NAME install.docs COMMAND bash ${PROJECT_SOURCE_DIR}/tests/install/docs.sh
    ${PROJECT_BINARY_DIR}/docs WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
  set_tests_properties(install.docs PROPERTIES LABELS install SKIP_RETURN_CODE 77)
endif()
