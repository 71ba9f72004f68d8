# Settings that hold for every room: layout of the build, warnings, visibility, sanitizers, ccache.

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

# The plugin directory is found from the executable, so build and installation share one layout.
if(NOT DEFINED CMAKE_INSTALL_LIBDIR)
  set(CMAKE_INSTALL_LIBDIR lib CACHE PATH "Directory of libraries in the installation")
endif()
include(GNUInstallDirs)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_BINDIR}")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/${CMAKE_INSTALL_LIBDIR}")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/archive")
set(TENDRIL_PLUGIN_SUBDIRECTORY tendril/plugins)
set(TENDRIL_PLUGIN_OUTPUT_DIRECTORY "${CMAKE_LIBRARY_OUTPUT_DIRECTORY}/${TENDRIL_PLUGIN_SUBDIRECTORY}")
# The same run path in build and installation. CMake would else fill up the shorter one with ':', an empty entry, which the
# loader takes for the current directory.
set(CMAKE_INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}")
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

add_compile_options(-Wall -Wextra -Wpedantic -Wconversion -Wshadow)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 warns falsely inside std::string and Eigen (bugs 105329 and 105651), depending on what it inlines.
  add_compile_options(-Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread -Wno-array-bounds)
endif()
if(CMAKE_UNITY_BUILD)
  # What one source of a folder declares, another does not hide: only what hides something local counts (clang, which
  # knows no such form, builds the fuzzers alone).
  add_compile_options(-Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>)
endif()
if(TENDRIL_WERROR)
  add_compile_options(-Werror)
endif()

if(TENDRIL_SANITIZERS)
  add_compile_options(-fsanitize=${TENDRIL_SANITIZERS} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${TENDRIL_SANITIZERS})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # GCC's documentation: sanitizers lead to more false warnings, this one above all.
    add_compile_options(-Wno-maybe-uninitialized)
  endif()
endif()

if(TENDRIL_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
    message(FATAL_ERROR "TENDRIL_FUZZ needs clang, whose libFuzzer drives the readers")
  endif()
  # Tells the fuzzer which branches an input took; only the fuzzers themselves link its main().
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()

if(PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(TENDRIL_CCACHE ccache)
  mark_as_advanced(TENDRIL_CCACHE)
  if(TENDRIL_CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER "${TENDRIL_CCACHE}")
  endif()
endif()
# ccache takes precompiled headers only when told that their macros and times do not matter, and knows a source again in
# another clone only when paths count from where the clone stands.
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache$" AND TENDRIL_PCH)
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env
      "CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime"
      "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" "CCACHE_NOHASHDIR=1"
      ${CMAKE_CXX_COMPILER_LAUNCHER})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    add_compile_options(-fpch-preprocess)
  else()
    add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
  endif()
endif()

# Precompiles `headers` for `target`, unless TENDRIL_PCH is off.
function(tendril_precompile target)
  if(TENDRIL_PCH)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# With CMAKE_UNITY_BUILD the sources of one folder, at most a dozen, are compiled as one: what they instantiate of Eigen, of GoogleTest
# and of the readers' libraries is then compiled once. More at a time would leave the other processors without work.
function(tendril_unite target)
  set(most 12)
  get_target_property(sources ${target} SOURCES)
  get_target_property(home ${target} SOURCE_DIR)
  set(folders)
  foreach(source IN LISTS sources)
    get_filename_component(source "${source}" ABSOLUTE BASE_DIR "${home}")
    get_filename_component(folder "${source}" DIRECTORY)
    list(APPEND folders "${folder}")
    list(APPEND "in ${folder}" "${source}")
  endforeach()
  list(REMOVE_DUPLICATES folders)
  foreach(folder IN LISTS folders)
    get_filename_component(name "${folder}" NAME)
    list(LENGTH "in ${folder}" count)
    if(count EQUAL 1)
      continue()
    endif()
    math(EXPR parts "(${count} + ${most} - 1) / ${most}")
    set(index 0)
    foreach(source IN LISTS "in ${folder}")
      math(EXPR part "${index} * ${parts} / ${count} + 1")
      set_source_files_properties("${source}" TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP "${name}_${part}")
      math(EXPR index "${index} + 1")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()

# The same for all that `directory` and those below it build.
function(tendril_unite_directory directory)
  get_property(targets DIRECTORY "${directory}" PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target IN LISTS targets)
    get_target_property(type ${target} TYPE)
    if(type MATCHES "EXECUTABLE|_LIBRARY" AND NOT type STREQUAL "INTERFACE_LIBRARY")
      tendril_unite(${target})
    endif()
  endforeach()
  get_property(below DIRECTORY "${directory}" PROPERTY SUBDIRECTORIES)
  foreach(one IN LISTS below)
    tendril_unite_directory("${one}")
  endforeach()
endfunction()
