# tendril_add_plugin(KIND coordinates|objective|obstacle|solver NAME name SOURCES file... [LINK library...]
#                    [OUTPUT_DIRECTORY directory] [TARGET target])
#
# Builds one plugin, the library tendril-<kind>-<name>.so. Works inside tendril's tree and, after find_package(tendril), in
# any other project. TARGET is the CMake target's name, by default tendril-<kind>-<name>. Inside the tree the plugin is put
# where the build's own executables look; elsewhere in the project's binary directory unless OUTPUT_DIRECTORY says otherwise.
function(tendril_add_plugin)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "KIND;NAME;OUTPUT_DIRECTORY;TARGET" "SOURCES;LINK")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tendril_add_plugin: unknown arguments '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  set(kinds coordinates objective obstacle solver)
  if(NOT arg_KIND IN_LIST kinds)
    message(FATAL_ERROR "tendril_add_plugin: KIND is '${arg_KIND}'; expected one of ${kinds}")
  endif()
  if(NOT arg_NAME MATCHES "^[a-z][a-z0-9_]*$")
    message(FATAL_ERROR "tendril_add_plugin: NAME is '${arg_NAME}'; expected lower-case letters, digits and '_'")
  endif()
  if(NOT arg_SOURCES)
    message(FATAL_ERROR "tendril_add_plugin: ${arg_KIND} '${arg_NAME}' has no SOURCES")
  endif()
  if(NOT arg_TARGET)
    set(arg_TARGET tendril-${arg_KIND}-${arg_NAME})
  endif()

  add_library(${arg_TARGET} MODULE ${arg_SOURCES})
  target_link_libraries(${arg_TARGET} PRIVATE tendril::tendril ${arg_LINK})
  target_compile_features(${arg_TARGET} PRIVATE cxx_std_20)
  set_target_properties(
    ${arg_TARGET}
    PROPERTIES PREFIX ""
               SUFFIX ".so"
               OUTPUT_NAME tendril-${arg_KIND}-${arg_NAME}
               CXX_VISIBILITY_PRESET hidden
               VISIBILITY_INLINES_HIDDEN ON)
  # Unique symbols would be shared by all loaded libraries, whatever their visibility, and would keep them from being told apart.
  target_compile_options(${arg_TARGET} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)
  # A missing symbol is found here and not when a user opens the plugin. Clang links the sanitizers' runtime into the
  # executable only, so its plugins have undefined symbols.
  set(sanitizers "${TENDRIL_SANITIZERS} ${CMAKE_CXX_FLAGS}")
  if(NOT (CMAKE_CXX_COMPILER_ID MATCHES "Clang" AND sanitizers MATCHES "address|undefined|memory|thread"))
    target_link_options(${arg_TARGET} PRIVATE -Wl,-z,defs)
  endif()

  if(arg_OUTPUT_DIRECTORY)
    set_target_properties(${arg_TARGET} PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${arg_OUTPUT_DIRECTORY}")
  elseif(TENDRIL_PLUGIN_OUTPUT_DIRECTORY)
    set_target_properties(${arg_TARGET} PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${TENDRIL_PLUGIN_OUTPUT_DIRECTORY}"
                                                   INSTALL_RPATH "$ORIGIN/../..")
    add_dependencies(tendril-all-plugins ${arg_TARGET})
    set_property(GLOBAL APPEND PROPERTY TENDRIL_PLUGINS ${arg_KIND}:${arg_NAME})
    # Solvers bring libraries with licences of their own, so each is a package of its own.
    set(component tendril)
    if(arg_KIND STREQUAL "solver")
      set(component ${arg_TARGET})
      set_property(GLOBAL APPEND PROPERTY TENDRIL_SOLVER_COMPONENTS ${component})
    endif()
    install(TARGETS ${arg_TARGET} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/${TENDRIL_PLUGIN_SUBDIRECTORY}"
                                          COMPONENT ${component})
  endif()
endfunction()
