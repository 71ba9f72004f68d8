# Installation, and the package that find_package(tendril) finds. The build directory itself serves as a package too.

include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/tendril")
install(
  TARGETS tendril tendril-files
  EXPORT tendril-targets
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
          COMPONENT tendril
          NAMELINK_COMPONENT tendril-dev)
install(
  TARGETS tendril-plugins
  EXPORT tendril-targets
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT tendril-dev)
install(
  DIRECTORY "${PROJECT_SOURCE_DIR}/core/include/tendril" "${PROJECT_SOURCE_DIR}/plugins/include/tendril"
            "${PROJECT_SOURCE_DIR}/app/include/tendril"
  DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}"
  COMPONENT tendril-dev
  PATTERN "tendril/app" EXCLUDE)
install(
  EXPORT tendril-targets
  NAMESPACE tendril::
  DESTINATION "${package_dir}"
  COMPONENT tendril-dev)
export(EXPORT tendril-targets NAMESPACE tendril:: FILE "${PROJECT_BINARY_DIR}/tendril-targets.cmake")

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/tendril-config.cmake.in" tendril-config.cmake
                              INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file(tendril-config-version.cmake VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
set(modules TendrilPlugin.cmake TendrilTestPlugin.cmake)
foreach(module IN LISTS modules)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${module}" "${PROJECT_BINARY_DIR}/${module}" COPYONLY)
  install(
    FILES "${PROJECT_SOURCE_DIR}/cmake/${module}"
    DESTINATION "${package_dir}"
    COMPONENT tendril-dev)
endforeach()
install(
  FILES "${PROJECT_BINARY_DIR}/tendril-config.cmake" "${PROJECT_BINARY_DIR}/tendril-config-version.cmake"
  DESTINATION "${package_dir}"
  COMPONENT tendril-dev)
# As they lie in the sources, so that their links lead somewhere.
install(
  FILES "${PROJECT_SOURCE_DIR}/README.md" "${PROJECT_SOURCE_DIR}/LICENSE" "${PROJECT_SOURCE_DIR}/THIRD_PARTY.md"
  DESTINATION "${CMAKE_INSTALL_DOCDIR}"
  COMPONENT tendril)
install(
  DIRECTORY "${PROJECT_SOURCE_DIR}/docs" "${PROJECT_SOURCE_DIR}/scenes"
  DESTINATION "${CMAKE_INSTALL_DOCDIR}"
  COMPONENT tendril
  PATTERN "*.in" EXCLUDE)
install(
  DIRECTORY "${PROJECT_SOURCE_DIR}/examples"
  DESTINATION "${CMAKE_INSTALL_DOCDIR}"
  COMPONENT tendril-dev)
