# The tool opens what needs OpenVDB, NetCDF, TIFF or libmicrohttpd when it is asked for (tool/modules/module.h): beside itself
# in the build folder, installed in a folder of the libraries that it knows from its own.
file(RELATIVE_PATH folder ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR}/bccsplat)
# Modules of another build are refused: the name of what they export holds the version and a digest of the types that they
# share with the tool.
set(shared_types readers/frame_reader.h ../src/series/frame_reader.h ../src/series/value_type.h
  readers/name_numbers.h readers/reader_options.h readers/sequence.h readers/value_type.h ../src/base/error.h
  tool/output/vdb_output.h tool/output/volume_file.h tool/serve/http_server.h tool/modules/module.h)
set(digests)
foreach(header IN LISTS shared_types)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${header})
  file(SHA256 ${CMAKE_CURRENT_SOURCE_DIR}/${header} digest)
  string(APPEND digests ${digest})
endforeach()
string(SHA256 digest "${digests}")
string(SUBSTRING ${digest} 0 16 digest)
string(MAKE_C_IDENTIFIER "bcc4_module_${PROJECT_VERSION}_${digest}" entry)

target_sources(bcc4 PRIVATE tool/modules/open_module.cpp)
set_source_files_properties(tool/modules/open_module.cpp PROPERTIES
  COMPILE_DEFINITIONS "BCC4_MODULE_ENTRY=\"${entry}\";BCC4_MODULE_FOLDER=\"${folder}\"")
if(BCCSPLAT_WITH_MICROHTTPD)
  set_property(SOURCE tool/modules/open_module.cpp APPEND PROPERTY COMPILE_DEFINITIONS BCCSPLAT_WITH_MICROHTTPD=1)
endif()
target_link_libraries(bcc4 PRIVATE ${CMAKE_DL_LIBS})
foreach(module IN LISTS modules)
  string(REPLACE bcc4_ tool/modules/ source ${module})
  add_library(${module}_module MODULE ${source}_module.cpp)
  set_target_properties(${module}_module PROPERTIES PREFIX "" OUTPUT_NAME ${module}
    LIBRARY_OUTPUT_DIRECTORY $<TARGET_FILE_DIR:bcc4>)
  target_compile_definitions(${module}_module PRIVATE BCC4_MODULE_ENTRY=${entry})
  target_link_libraries(${module}_module PRIVATE ${module} bccsplat_flags)
  # The sanitizers' functions come with clang's executables.
  if(NOT (BCCSPLAT_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES Clang))
    target_link_options(${module}_module PRIVATE -Wl,--no-undefined)
  endif()
  add_dependencies(bcc4 ${module}_module)
endforeach()
