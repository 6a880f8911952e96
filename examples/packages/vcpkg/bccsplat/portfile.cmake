# The library by vcpkg, of the checkout that this port lies in:
#   vcpkg install bccsplat --overlay-ports=examples/packages/vcpkg
# In a registry vcpkg_from_github stands for the next line.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)

# Names other than bccsplat_* are local to the shared library alone.
vcpkg_check_linkage(ONLY_DYNAMIC_LIBRARY)
vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS
  FEATURES
    gpu BCCSPLAT_WITH_GPU
    images BCCSPLAT_WITH_IMAGE
)
vcpkg_find_acquire_program(PKGCONFIG)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    ${FEATURE_OPTIONS}
    "-DPKG_CONFIG_EXECUTABLE=${PKGCONFIG}"
    -DBCCSPLAT_BUILD_TOOL=OFF
    -DBCCSPLAT_BUILD_TESTS=OFF
    -DBCCSPLAT_BUILD_BENCH=OFF
    -DBCCSPLAT_BUILD_EXAMPLES=OFF
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/bccsplat)
vcpkg_fixup_pkgconfig()

# The header is one for both builds; Python's package is pip's (examples/python/build_wheel.sh).
file(REMOVE_RECURSE
  "${CURRENT_PACKAGES_DIR}/debug/include"
  "${CURRENT_PACKAGES_DIR}/lib/python3"
  "${CURRENT_PACKAGES_DIR}/debug/lib/python3"
)
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
