# Debian packages by `cpack` in the build folder, one per component. For the system's own folders configure with
# -DCMAKE_INSTALL_PREFIX=/usr.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME bccsplat)
set(CPACK_PACKAGE_VENDOR bccsplat)
set(CPACK_PACKAGE_CONTACT "bccsplat maintainers <maintainers@bccsplat.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL "")
if(TARGET bccsplat)
  list(APPEND CPACK_COMPONENTS_ALL runtime development python)
endif()
if(TARGET bcc4)
  list(APPEND CPACK_COMPONENTS_ALL tools)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# dpkg-shlibdeps finds our own library here before any package of it exists.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(this_version "(= ${PROJECT_VERSION})")

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libbccsplat0)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "4D volumes on the D4* lattice: shared library
 Stores time-varying volumes as relevant points of the D4* lattice, cuts 3D
 slices out of them and draws those by splatting, behind a C interface.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libbccsplat-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libbccsplat0 ${this_version}")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "4D volumes on the D4* lattice: development files
 The header, which is the manual, and what CMake and pkg-config need to find
 the library.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-bccsplat)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "libbccsplat0 ${this_version}, python3 (>= 3.9), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "4D volumes on the D4* lattice: Python module
 The whole interface through ctypes and numpy, with type annotations.")

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME bccsplat-tools)
set(CPACK_DEBIAN_TOOLS_PACKAGE_SECTION utils)
set(CPACK_DEBIAN_TOOLS_PACKAGE_DEPENDS "libbccsplat0 ${this_version}")
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "4D volumes on the D4* lattice: converter and renderer
 bcc4 converts series of volumes, checks them and draws pictures of them.")
include(CPack)
