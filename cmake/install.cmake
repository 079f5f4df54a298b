# What `cmake --install` puts where: the static libraries with their headers, a CMake package, a
# pkg-config file, and the plugins for Cyclone DDS with a drop-in folder. Included last.
# The components are the Debian packages (packages.cmake): plugins, tools, dev, keeper.
include(CMakePackageConfigHelpers)

get_property(ddssec_libraries GLOBAL PROPERTY DDSSEC_LIBRARIES)
list(REMOVE_ITEM ddssec_libraries cyclonedds)  # only its plugins are of use outside
foreach(library ${ddssec_libraries})
  set_target_properties(ddssec_${library} PROPERTIES EXPORT_NAME ${library})
  install(TARGETS ddssec_${library} EXPORT ddssecTargets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/public_headers.cmake)
foreach(header ${DDSSEC_PUBLIC_HEADERS} ${DDSSEC_CARRIED_HEADERS})
  cmake_path(GET header PARENT_PATH folder)
  install(FILES ${PROJECT_SOURCE_DIR}/${header}
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/ddssec/${folder} COMPONENT dev)
endforeach()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ddssec)
install(EXPORT ddssecTargets NAMESPACE ddssec:: DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/ddssecConfig.cmake.in
  ${CMAKE_BINARY_DIR}/ddssecConfig.cmake INSTALL_DESTINATION ${package_dir}
  PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/ddssecConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/ddssecConfig.cmake ${CMAKE_BINARY_DIR}/ddssecConfigVersion.cmake
              ${CMAKE_CURRENT_LIST_DIR}/ddssecIdl.cmake
        DESTINATION ${package_dir} COMPONENT dev)

# The static libraries by their file names: in a build folder -l would find the plugins for Cyclone DDS, which
# have the same names and export nothing. A group, because a linker reads each archive only once.
list(TRANSFORM ddssec_libraries REPLACE "(.+)" "-l:libddssec_\\1.a"
     OUTPUT_VARIABLE DDSSEC_PC_LIBRARIES)
list(JOIN DDSSEC_PC_LIBRARIES " " DDSSEC_PC_LIBRARIES)
if(IPSEC_MB_LIBRARY)
  set(DDSSEC_PC_IPSEC_MB "-lIPSec_MB")
endif()
# Relative, so that the installed tree may be moved.
file(RELATIVE_PATH DDSSEC_PC_PREFIX_FROM_LIBDIR /prefix/${CMAKE_INSTALL_LIBDIR} /prefix)
configure_file(${CMAKE_CURRENT_LIST_DIR}/ddssec.pc.in ${CMAKE_BINARY_DIR}/ddssec.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/ddssec.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

get_property(plugins GLOBAL PROPERTY DDSSEC_CYCLONEDDS_PLUGINS)
foreach(plugin ${plugins})
  get_target_property(cyclone_name ${plugin} DDSSEC_CYCLONE_NAME)
  get_target_property(name ${plugin} OUTPUT_NAME)
  # Not in a folder that the loader searches: nothing links them.
  install(TARGETS ${plugin} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/ddssec COMPONENT plugins)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/installed-dropin)
  file(CREATE_LINK ../lib${name}.so
       ${CMAKE_BINARY_DIR}/installed-dropin/lib${cyclone_name}.so SYMBOLIC)
endforeach()
if(plugins)
  install(DIRECTORY ${CMAKE_BINARY_DIR}/installed-dropin/
          DESTINATION ${CMAKE_INSTALL_LIBDIR}/ddssec/dropin COMPONENT plugins)
endif()
