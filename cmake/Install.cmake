# What an install holds: the library, its headers, the program, and what find_package(holdfast) and pkg-config need.
include(CMakePackageConfigHelpers)

# Eigen's matrices of run-time size are allocated by one side and freed by the other, and how depends on EIGEN_MAX_ALIGN_BYTES, which
# follows -march. So whoever links the library from outside compiles with the value it was compiled with (fixed-size types are never
# aligned: graph/math.hpp). A program built with -march=native then works as it is.
if(NOT DEFINED HOLDFAST_EIGEN_ALIGN)
  include(CheckCXXSourceCompiles)
  get_target_property(CMAKE_REQUIRED_INCLUDES Eigen3::Eigen INTERFACE_INCLUDE_DIRECTORIES)
  set(HOLDFAST_EIGEN_ALIGN 16)
  foreach(bytes IN ITEMS 64 32)
    check_cxx_source_compiles("#include <Eigen/Core>\nstatic_assert(EIGEN_MAX_ALIGN_BYTES == ${bytes}, \"\");\nint main() {}"
      HOLDFAST_ALIGNS_${bytes})
    if(HOLDFAST_ALIGNS_${bytes})
      set(HOLDFAST_EIGEN_ALIGN ${bytes})
    endif()
  endforeach()
  unset(CMAKE_REQUIRED_INCLUDES)
endif()
if(PROJECT_IS_TOP_LEVEL)  # in its own build tree every target has the same flags
  target_compile_definitions(holdfast INTERFACE $<INSTALL_INTERFACE:EIGEN_MAX_ALIGN_BYTES=${HOLDFAST_EIGEN_ALIGN}>)
else()
  target_compile_definitions(holdfast INTERFACE EIGEN_MAX_ALIGN_BYTES=${HOLDFAST_EIGEN_ALIGN})
endif()

set(installed holdfast)
foreach(part IN LISTS HOLDFAST_PARTS)
  if(TARGET holdfast_${part})
    list(APPEND installed holdfast_${part})
  endif()
  if(TARGET holdfast_${part}_adapter)
    list(APPEND installed holdfast_${part}_adapter)
  endif()
endforeach()
install(TARGETS ${installed} EXPORT holdfastTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET holdfast_cli)
  install(TARGETS holdfast_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
foreach(folder IN ITEMS graph factors solvers adapters)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/holdfast/${folder}
    FILES_MATCHING PATTERN "*.hpp" PATTERN internal EXCLUDE)
endforeach()
install(FILES holdfast.hpp tests/testing.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/holdfast)
install(DIRECTORY tests/testing/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/holdfast/testing FILES_MATCHING PATTERN "*.hpp")

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/holdfast)
install(EXPORT holdfastTargets NAMESPACE holdfast:: DESTINATION ${package_dir})
configure_package_config_file(cmake/holdfastConfig.cmake.in ${PROJECT_BINARY_DIR}/holdfastConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/FindPETSc.cmake DESTINATION ${package_dir})
install(FILES ${PROJECT_BINARY_DIR}/holdfastConfig.cmake ${PROJECT_BINARY_DIR}/holdfastConfigVersion.cmake DESTINATION ${package_dir})

# pkg-config: the core and what is linked into it; the parts mrpt, gtsam and g2o are for CMake alone.
set(HOLDFAST_PC_LIBS "-lpthread")
if(HOLDFAST_WITH_METIS)
  string(PREPEND HOLDFAST_PC_LIBS "-lmetis ")
endif()
if(HOLDFAST_WITH_CERES)
  get_target_property(ceres_links Ceres::ceres INTERFACE_LINK_LIBRARIES)
  if(ceres_links MATCHES "glog")  # from 2.3 on Ceres logs by Abseil
    string(PREPEND HOLDFAST_PC_LIBS "-lglog ")
  endif()
  string(PREPEND HOLDFAST_PC_LIBS "-lceres ")
endif()
foreach(folder IN ITEMS INCLUDEDIR LIBDIR)
  if(IS_ABSOLUTE "${CMAKE_INSTALL_${folder}}")
    set(HOLDFAST_PC_${folder} "${CMAKE_INSTALL_${folder}}")
  else()
    set(HOLDFAST_PC_${folder} "\${prefix}/${CMAKE_INSTALL_${folder}}")
  endif()
endforeach()
configure_file(cmake/holdfast.pc.in ${PROJECT_BINARY_DIR}/holdfast.pc.configured @ONLY)
install(CODE "
  file(READ \"${PROJECT_BINARY_DIR}/holdfast.pc.configured\" text)
  string(REGEX REPLACE \"^prefix=[^\n]*\" \"prefix=\${CMAKE_INSTALL_PREFIX}\" text \"\${text}\")
  file(WRITE \"${PROJECT_BINARY_DIR}/holdfast.pc\" \"\${text}\")")  # the prefix of this install, which --prefix may have changed
install(FILES ${PROJECT_BINARY_DIR}/holdfast.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# What colcon and rosdep know a package by.
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/holdfast)
