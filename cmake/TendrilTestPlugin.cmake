# tendril_test_plugin(KIND coordinates|objective|obstacle|solver NAME name [SCENE file] [TARGET target])
#
# Adds the tests of a plugin that tendril_add_plugin() builds:
#   <name>.check  what every plugin of its kind has to keep (derivatives, distances, ...; a solver: the conformance suite)
#   <name>.plan   SCENE, planned with the plugin, ends solved
# A plugin that does not return fails both: the check names it after 60 s, and ctest ends what goes on after 120 s.
# The check takes the plugin's options from SCENE too; without one the defaults are tested. TENDRIL_TEST_SOLVER, if set,
# plans scenes with another solver than the one that they name.
function(tendril_test_plugin)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "KIND;NAME;SCENE;TARGET" "")
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "tendril_test_plugin: unknown arguments '${arg_UNPARSED_ARGUMENTS}'")
  endif()
  if(NOT arg_TARGET)
    set(arg_TARGET tendril-${arg_KIND}-${arg_NAME})
  endif()
  if(NOT TARGET ${arg_TARGET})
    message(FATAL_ERROR "tendril_test_plugin: there is no target '${arg_TARGET}'; expected a plugin that tendril_add_plugin(KIND "
                        "${arg_KIND} NAME ${arg_NAME} ...) has added before")
  endif()
  foreach(program IN ITEMS check-plugin conformance)
    if(NOT TARGET tendril::${program})
      message(FATAL_ERROR "tendril_test_plugin: this tendril was built with TENDRIL_TESTS=OFF and has no test kits")
    endif()
  endforeach()
  if(arg_SCENE)
    get_filename_component(arg_SCENE "${arg_SCENE}" ABSOLUTE)
  endif()

  set(directory "$<TARGET_FILE_DIR:${arg_TARGET}>")
  if(arg_KIND STREQUAL "solver")
    add_test(NAME ${arg_NAME}.check COMMAND $<TARGET_FILE:tendril::conformance> --solver ${arg_NAME} --plugin-dir "${directory}"
                                            --gtest_filter=EverySolver/* --gtest_brief=1)
    set(solver ${arg_NAME})
  else()
    set(scene)
    if(arg_SCENE)
      set(scene --scene "${arg_SCENE}")
    endif()
    add_test(NAME ${arg_NAME}.check COMMAND $<TARGET_FILE:tendril::check-plugin> ${arg_KIND} ${arg_NAME} --plugin-dir
                                            "${directory}" ${scene})
    set(solver ${TENDRIL_TEST_SOLVER})
  endif()
  if(arg_SCENE)
    set(other)
    if(solver)
      set(other --solver ${solver})
    endif()
    add_test(NAME ${arg_NAME}.plan COMMAND $<TARGET_FILE:tendril::command> plan "${arg_SCENE}" --plugin-dir "${directory}" ${other})
    set_tests_properties(${arg_NAME}.plan PROPERTIES TIMEOUT 120)
  endif()
  # The conformance suite tries time limits of its own.
  set(limit 120)
  if(arg_KIND STREQUAL "solver")
    set(limit 600)
  endif()
  set_tests_properties(${arg_NAME}.check PROPERTIES TIMEOUT ${limit})
endfunction()
