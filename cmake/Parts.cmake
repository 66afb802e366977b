# Parts that need a foreign library: AUTO (on where found), ON (an error where absent) or OFF.
# A file of a room whose name starts with a part's name belongs to it: solvers/ceres.cpp, tests/adapters/test_mrpt_graph.cpp.

set(HOLDFAST_PARTS "")

# holdfast_part(CERES PACKAGES Ceres TARGETS Ceres::ceres APT libceres-dev) sets HOLDFAST_WITH_CERES and, where on,
# makes the target holdfast::ceres: the library together with the foreign one.
macro(holdfast_part NAME)
  cmake_parse_arguments(part "" "" "PACKAGES;TARGETS;APT" ${ARGN})
  string(TOLOWER ${NAME} part_lower)
  list(APPEND HOLDFAST_PARTS ${part_lower})
  set(HOLDFAST_${NAME} AUTO CACHE STRING "Build what needs ${part_PACKAGES}: AUTO, ON or OFF")
  set_property(CACHE HOLDFAST_${NAME} PROPERTY STRINGS AUTO ON OFF)
  set(HOLDFAST_WITH_${NAME} OFF)
  set(part_absent "")
  if(HOLDFAST_${NAME})
    foreach(package IN LISTS part_PACKAGES)
      find_package(${package} QUIET)
      if(NOT ${package}_FOUND)
        list(APPEND part_absent ${package})
      endif()
    endforeach()
    if(NOT part_absent)
      set(HOLDFAST_WITH_${NAME} ON)
    elseif(NOT HOLDFAST_${NAME} STREQUAL "AUTO")
      list(JOIN part_APT " " part_apt)
      message(FATAL_ERROR "HOLDFAST_${NAME}=${HOLDFAST_${NAME}}, but ${part_absent} was not found. Install it (Debian: apt install ${part_apt}), "
        "name its folder in CMAKE_PREFIX_PATH, or configure with -DHOLDFAST_${NAME}=OFF (AUTO: on where found).")
    endif()
  endif()
  if(HOLDFAST_WITH_${NAME})
    add_library(holdfast_${part_lower} INTERFACE)
    add_library(holdfast::${part_lower} ALIAS holdfast_${part_lower})
    set_target_properties(holdfast_${part_lower} PROPERTIES EXPORT_NAME ${part_lower})
    target_link_libraries(holdfast_${part_lower} INTERFACE holdfast ${part_TARGETS})
  endif()
  message(STATUS "holdfast: ${part_lower} ${HOLDFAST_WITH_${NAME}} (HOLDFAST_${NAME}=${HOLDFAST_${NAME}})")
endmacro()

# Takes the files of the parts that are off out of the list.
function(holdfast_without_absent_parts list)
  foreach(part IN LISTS HOLDFAST_PARTS)
    string(TOUPPER ${part} PART)
    if(NOT HOLDFAST_WITH_${PART})
      list(FILTER ${list} EXCLUDE REGEX "/(solvers|adapters|benchmarks)/(test_|micro_)?${part}[^/]*$")
    endif()
  endforeach()
  set(${list} ${${list}} PARENT_SCOPE)
endfunction()

# Links the parts that are on, and tells the sources: HOLDFAST_WITH_CERES=1.
function(holdfast_link_parts target)
  foreach(part IN LISTS HOLDFAST_PARTS)
    string(TOUPPER ${part} PART)
    if(HOLDFAST_WITH_${PART})
      target_link_libraries(${target} PUBLIC holdfast::${part})
      target_compile_definitions(${target} PUBLIC HOLDFAST_WITH_${PART}=1)
    endif()
  endforeach()
endfunction()

# A symbolic link in the build folder to a path of the source folder, which need not exist yet.
function(holdfast_link source link)
  get_filename_component(folder ${PROJECT_BINARY_DIR}/${link} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${source} ${PROJECT_BINARY_DIR}/${link} SYMBOLIC)
endfunction()
