# bccsplat.dll: only what the header exports is visible (BCCSPLAT_API), so that no map of versions is needed. Beside it
# libbccsplat.dll.a, which MinGW links, and bccsplat.lib and bccsplat.def, which MSVC does.
set_target_properties(bccsplat PROPERTIES PREFIX "")
set(definitions ${CMAKE_CURRENT_BINARY_DIR}/bccsplat.def)
target_link_options(bccsplat PRIVATE -Wl,--output-def,${definitions})
find_program(BCCSPLAT_DLLTOOL NAMES x86_64-w64-mingw32-dlltool dlltool REQUIRED)
add_custom_command(TARGET bccsplat POST_BUILD
  COMMAND ${BCCSPLAT_DLLTOOL} -d ${definitions} -D bccsplat.dll -l ${CMAKE_CURRENT_BINARY_DIR}/bccsplat.lib
  VERBATIM)
