# The Debian packages: `cpack` in a build folder, or scripts/packages.sh. One for each component of install.cmake.
# What only packages contain is EXCLUDE_FROM_ALL: `cmake --install` leaves it out.
set(DDSSEC_PACKAGE_VERSION "" CACHE STRING "Version of the Debian packages; default: that of the project and -1")
set(DDSSEC_PACKAGE_MAINTAINER "ddssec maintainers <maintainers@ddssec.example.org>" CACHE STRING
    "Maintainer of the Debian packages: a name and an address")

set(packaging ${PROJECT_SOURCE_DIR}/packaging)
set(generated ${CMAKE_BINARY_DIR}/packaging)
set(CPACK_COMPONENTS_ALL tools dev keeper)
get_property(plugins GLOBAL PROPERTY DDSSEC_CYCLONEDDS_PLUGINS)
if(plugins)
  list(PREPEND CPACK_COMPONENTS_ALL plugins)
endif()

# SOURCE_DATE_EPOCH, or the time of the last commit: the same source gives the same packages.
set(epoch $ENV{SOURCE_DATE_EPOCH})
if(NOT epoch)
  execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} log -1 --format=%ct OUTPUT_VARIABLE epoch
                  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(NOT epoch)
  string(TIMESTAMP epoch "%s" UTC)
endif()
set(CPACK_DDSSEC_EPOCH ${epoch})
execute_process(COMMAND date -u -R -d @${epoch} OUTPUT_VARIABLE DDSSEC_PACKAGE_DATE OUTPUT_STRIP_TRAILING_WHITESPACE)
configure_file(${packaging}/changelog.in ${generated}/changelog.Debian @ONLY)
foreach(file ${generated}/changelog.Debian ${PROJECT_SOURCE_DIR}/CHANGELOG.md)
  get_filename_component(name ${file} NAME)
  string(REPLACE "CHANGELOG.md" "changelog" name ${name})
  execute_process(COMMAND gzip -9nc ${file} OUTPUT_FILE ${generated}/${name}.gz COMMAND_ERROR_IS_FATAL ANY)
endforeach()
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/CHANGELOG.md)

foreach(component ${CPACK_COMPONENTS_ALL})
  set(package ddssec-${component})
  set(folder ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES ${packaging}/copyright ${generated}/changelog.gz ${generated}/changelog.Debian.gz
          DESTINATION ${folder} COMPONENT ${component} EXCLUDE_FROM_ALL)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
endforeach()

# Debian's manual pages are compressed.
install(FILES ${CMAKE_BINARY_DIR}/cli/ddssec.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT tools
        EXCLUDE_FROM_ALL)
install(CODE "execute_process(
              COMMAND gzip -9nf \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1/ddssec.1\"
              COMMAND_ERROR_IS_FATAL ANY)" COMPONENT tools EXCLUDE_FROM_ALL)
# Debian's zsh does not search site-functions below /usr.
install(FILES ${CMAKE_BINARY_DIR}/cli/completion.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions
        RENAME _ddssec COMPONENT tools EXCLUDE_FROM_ALL)
install(FILES ${packaging}/keeper/ddssec-keeper.service DESTINATION lib/systemd/system COMPONENT keeper
        EXCLUDE_FROM_ALL)
install(FILES ${packaging}/keeper/ddssec-keeper.sysusers DESTINATION lib/sysusers.d RENAME ddssec-keeper.conf
        COMPONENT keeper EXCLUDE_FROM_ALL)
install(FILES ${packaging}/keeper/ddssec-keeper.default DESTINATION ../etc/default RENAME ddssec-keeper
        COMPONENT keeper EXCLUDE_FROM_ALL)
install(FILES ${packaging}/agent/ddssec-agent.service DESTINATION lib/systemd/system COMPONENT tools EXCLUDE_FROM_ALL)
install(FILES ${packaging}/agent/ddssec-agent.default DESTINATION ../etc/default RENAME ddssec-agent
        COMPONENT tools EXCLUDE_FROM_ALL)
install(FILES ${PROJECT_SOURCE_DIR}/programs/keeper/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/ddssec-keeper
        COMPONENT keeper EXCLUDE_FROM_ALL)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ddssec)
set(CPACK_PACKAGE_VENDOR ddssec)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each component has its own
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_VERSION "${PROJECT_VERSION}-1")
if(DDSSEC_PACKAGE_VERSION)
  set(CPACK_DEBIAN_PACKAGE_VERSION "${DDSSEC_PACKAGE_VERSION}")
endif()
set(CPACK_DEBIAN_PACKAGE_RELEASE "")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${DDSSEC_PACKAGE_MAINTAINER}")
set(CPACK_DEBIAN_PACKAGE_SECTION net)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)  # quick: finish.cmake compresses again
set(CPACK_DDSSEC_COMPRESSION xz)

set(CPACK_COMPONENT_PLUGINS_DESCRIPTION "DDS-Security plugins for Cyclone DDS
An unmodified Cyclone DDS loads these three libraries in place of its own:
authentication, access control and cryptography. They refuse participants that
signed their own permissions, read revocation lists again while participants
run, and say in a sentence why a peer is refused.
.
The folder /usr/lib/ddssec/dropin has them under the names of the stock
libraries. No application uses them until its configuration names them.")
set(CPACK_DEBIAN_PLUGINS_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_PLUGINS_PACKAGE_RECOMMENDS ddssec-tools)
set(CPACK_DEBIAN_PLUGINS_PACKAGE_ENHANCES "cyclonedds-tools, libddsc0debian")

set(CPACK_COMPONENT_TOOLS_DESCRIPTION "certificates, governance and permissions for DDS-Security
The program ddssec makes and renews certificates, writes, checks, compares and
signs governance and permissions documents, and finds out why two participants
do not talk. It reads and writes ROS 2 keystores.
.
`ddssec agent` renews certificates while participants run. Its sandboxed systemd
service is neither enabled nor started when the package is installed: it needs
folders and a CA first.
.
ddssec-peer and ddssec-shapes are test programs: they publish and subscribe,
secured or not, with any DDS product.")
# `ddssec inspect` loads libpcap, whose package has another name in Debian 13.
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS "ddssec-plugins, libpcap0.8 | libpcap0.8t64")
set(CPACK_DEBIAN_TOOLS_PACKAGE_CONTROL_EXTRA
    ${packaging}/agent/postinst ${packaging}/agent/prerm ${packaging}/agent/postrm ${packaging}/agent/conffiles)

set(CPACK_COMPONENT_DEV_DESCRIPTION "embedded DDS participant with DDS-Security: development files
Headers, static libraries, a CMake package and a pkg-config file for C++
applications that join a DDS domain without another DDS product. They talk,
secured, to Cyclone DDS and Fast DDS.
.
ddssec_idl_generate of the CMake package makes C++ types from IDL.")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(needed libfmt-dev libsodium-dev libsqlite3-dev libssl-dev libtinyxml2-dev nlohmann-json3-dev pkg-config)
if(IPSEC_MB_LIBRARY)
  list(APPEND needed libipsec-mb-dev)
endif()
list(JOIN needed ", " CPACK_DEBIAN_DEV_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_DEV_PACKAGE_RECOMMENDS "cyclonedds-tools, ddssec-tools")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS ddssec-plugins)

set(CPACK_COMPONENT_KEEPER_DESCRIPTION "durability service for DDS
ddssec-keeper joins a DDS domain as a secured participant, keeps what TRANSIENT
and PERSISTENT writers write, and gives it to late joiners, also when those
writers are gone.
.
The package has a sandboxed systemd service that is neither enabled nor started
when it is installed: it needs the keys and documents of a participant first.")
set(CPACK_DEBIAN_KEEPER_PACKAGE_DEPENDS "systemd | systemd-standalone-sysusers")
set(CPACK_DEBIAN_KEEPER_PACKAGE_RECOMMENDS "ddssec-tools")
set(CPACK_DEBIAN_KEEPER_PACKAGE_CONTROL_EXTRA
    ${packaging}/keeper/postinst ${packaging}/keeper/prerm ${packaging}/keeper/postrm ${packaging}/keeper/conffiles)

set(CPACK_POST_BUILD_SCRIPTS ${packaging}/finish.cmake)
include(CPack)
