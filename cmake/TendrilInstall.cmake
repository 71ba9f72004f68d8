# Installation, and the package that find_package(tendril) finds. The build directory itself serves as a package too.

include(CMakePackageConfigHelpers)

set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/tendril")
install(TARGETS tendril EXPORT tendril-targets LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}")
install(DIRECTORY "${PROJECT_SOURCE_DIR}/core/include/tendril" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}")
install(EXPORT tendril-targets NAMESPACE tendril:: DESTINATION "${package_dir}")
export(EXPORT tendril-targets NAMESPACE tendril:: FILE "${PROJECT_BINARY_DIR}/tendril-targets.cmake")

configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/tendril-config.cmake.in" tendril-config.cmake
                              INSTALL_DESTINATION "${package_dir}")
write_basic_package_version_file(tendril-config-version.cmake VERSION ${PROJECT_VERSION} COMPATIBILITY SameMinorVersion)
configure_file("${PROJECT_SOURCE_DIR}/cmake/TendrilPlugin.cmake" "${PROJECT_BINARY_DIR}/TendrilPlugin.cmake" COPYONLY)
install(
  FILES "${PROJECT_BINARY_DIR}/tendril-config.cmake" "${PROJECT_BINARY_DIR}/tendril-config-version.cmake"
        "${PROJECT_SOURCE_DIR}/cmake/TendrilPlugin.cmake"
  DESTINATION "${package_dir}")
