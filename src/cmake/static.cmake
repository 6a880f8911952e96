# The static library: one object with everything, in which only the bccsplat_* names are global, so that nothing of ours
# meets a host's symbols. What it needs itself is told by pkg-config --static and by the CMake package.
option(BCCSPLAT_STATIC "Build and install the static library as well" OFF)
if(BCCSPLAT_STATIC)
  add_library(bccsplat_static STATIC ${api_sources} $<TARGET_OBJECTS:bccsplat_core>)
  foreach(part IN LISTS choosing)
    target_sources(bccsplat_static PRIVATE $<TARGET_OBJECTS:${part}>)
    target_include_directories(bccsplat_static PRIVATE $<TARGET_PROPERTY:${part},INTERFACE_INCLUDE_DIRECTORIES>)
  endforeach()
  set_target_properties(bccsplat_static PROPERTIES OUTPUT_NAME bccsplat EXPORT_NAME static)
  target_compile_definitions(bccsplat_static PRIVATE BCCSPLAT_BUILDING=1
    $<TARGET_PROPERTY:bccsplat_core,INTERFACE_COMPILE_DEFINITIONS>)
  target_include_directories(bccsplat_static
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>
    PRIVATE $<TARGET_PROPERTY:bccsplat_core,INTERFACE_INCLUDE_DIRECTORIES>)
  # The flags are no business of those who link it.
  target_compile_options(bccsplat_static PRIVATE $<TARGET_PROPERTY:bccsplat_flags,INTERFACE_COMPILE_OPTIONS>)
  target_link_libraries(bccsplat_static INTERFACE $<BUILD_INTERFACE:bccsplat_core_libraries>
    $<INSTALL_INTERFACE:PkgConfig::BCCSPLAT_PRIVATE> $<INSTALL_INTERFACE:Threads::Threads>)
  set_target_properties(bccsplat_static PROPERTIES INTERFACE_LINK_OPTIONS "" LINKER_LANGUAGE CXX)
  add_library(bccsplat_core_libraries INTERFACE)
  target_link_libraries(bccsplat_core_libraries INTERFACE
    $<TARGET_PROPERTY:bccsplat_core,INTERFACE_LINK_LIBRARIES>)

  add_custom_command(TARGET bccsplat_static POST_BUILD
    COMMAND ${CMAKE_LINKER} -r --force-group-allocation --whole-archive $<TARGET_FILE:bccsplat_static>
      -o bccsplat_static.o
    COMMAND ${CMAKE_OBJCOPY} --wildcard --keep-global-symbol=bccsplat_* bccsplat_static.o
    COMMAND ${CMAKE_COMMAND} -E rm $<TARGET_FILE:bccsplat_static>
    COMMAND ${CMAKE_AR} rcs $<TARGET_FILE:bccsplat_static> bccsplat_static.o
    COMMAND ${CMAKE_COMMAND} -E rm bccsplat_static.o
    VERBATIM)
endif()
