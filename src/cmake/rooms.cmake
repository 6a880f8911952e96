# Which rooms and files a build is made of. Without the writer, files are read and drawn; without the splatter, pictures are
# the GPU's alone. What a part that is left out would have defined, without_PART.cpp of a room answers for.
option(BCCSPLAT_WITH_WRITER "Write and join .bcc4 files" ON)
option(BCCSPLAT_WITH_SPLAT "Pictures by the CPU: sheets, rays and the reference" ON)
option(BCCSPLAT_WITH_CUTS "Slices other than moments of time: planes, thick ones, the paper's points" ON)
option(BCCSPLAT_WITH_MOTION "Moments that follow what moves between frames" ON)

set(core_rooms base lattice kernel points field slice view motion shade volume draw scene)
if(BCCSPLAT_WITH_WRITER)
  list(APPEND core_rooms fit store)
endif()
if(BCCSPLAT_WITH_SPLAT)
  list(APPEND core_rooms splat rays reference)
endif()

# Of formats/bcc4 what only writes.
file(GLOB writing_formats CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/formats/bcc4/encode/*.cpp
  ${PROJECT_SOURCE_DIR}/formats/bcc4/write/*.cpp)
# Of the scene and the C ABI what a part alone needs, and what stands for it.
set(writer_files api/writer.cpp api/writer_options.cpp)
set(splat_files scene/trail.cpp scene/trail_layers.cpp)
set(cuts_files slice/axis_slice.cpp slice/coarser_plane.cpp slice/corrected_cut.cpp slice/extraction.cpp slice/extraction_points.cpp
  slice/gaussian_mean.cpp slice/lowpass_slice.cpp slice/occupancy.cpp slice/plane_slice.cpp
  slice/plane_spacing.cpp slice/thick_field.cpp slice/touched_samples.cpp slice/turned_samples.cpp)
file(GLOB motion_files CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} motion/*.cpp)
list(REMOVE_ITEM motion_files motion/without_motion.cpp)
# What a system has, and what stands for it in a browser: contexts by EGL, threads, numbers as text.
set(system_files gpu/gl_context.cpp base/tasks.cpp base/worker.cpp base/os/posix/thread_name.cpp)
set(browser_files gpu/web_context.cpp base/number_text.cpp base/without_threads.cpp)
# Calls of the operating system, in two forms.
set(posix_files file floats machine thread_name)
set(windows_files file floats machine thread_name wide)
foreach(system posix windows)
  list(TRANSFORM ${system}_files PREPEND base/os/${system}/)
  list(TRANSFORM ${system}_files APPEND .cpp)
endforeach()

# Takes from a list of sources those that the options leave out.
function(bccsplat_leave_out sources)
  set(out)
  foreach(part WRITER SPLAT CUTS MOTION)
    string(TOLOWER ${part} name)
    if(BCCSPLAT_WITH_${part})
      list(APPEND out scene/without_${name}.cpp api/without_${name}.cpp slice/without_${name}.cpp motion/without_${name}.cpp)
    else()
      list(APPEND out ${${name}_files})
    endif()
  endforeach()
  if(EMSCRIPTEN)
    list(APPEND out ${system_files})
  else()
    list(APPEND out ${browser_files})
  endif()
  if(WIN32)
    list(APPEND out ${posix_files})
  else()
    list(APPEND out ${windows_files})
  endif()
  list(TRANSFORM out PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  if(NOT BCCSPLAT_WITH_WRITER)
    list(APPEND out ${writing_formats})
  endif()
  list(REMOVE_ITEM ${sources} ${out})
  set(${sources} ${${sources}} PARENT_SCOPE)
endfunction()
