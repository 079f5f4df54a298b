# After cpack: writes each package again by dpkg-deb.
# - cpack's own scripts call ldconfig; our libraries are in no folder that it looks at.
# - cpack puts the time of its run into the packages. The time of the source gives the same packages each time.
set(ENV{SOURCE_DATE_EPOCH} ${CPACK_DDSSEC_EPOCH})
foreach(package ${CPACK_PACKAGE_FILES})
  set(folder ${package}.unpacked)
  file(REMOVE_RECURSE ${folder})
  execute_process(COMMAND dpkg-deb --raw-extract ${package} ${folder} COMMAND_ERROR_IS_FATAL ANY)
  foreach(script postinst postrm)
    if(EXISTS ${folder}/DEBIAN/${script})
      file(STRINGS ${folder}/DEBIAN/${script} calls REGEX "^[ \t]*ldconfig$")
      if(calls)
        file(REMOVE ${folder}/DEBIAN/${script})
      endif()
    endif()
  endforeach()
  execute_process(COMMAND find ${folder} -exec touch --no-dereference --date=@${CPACK_DDSSEC_EPOCH} {} +
                  COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND dpkg-deb --root-owner-group -Z${CPACK_DDSSEC_COMPRESSION} --build ${folder} ${package}
                  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE_RECURSE ${folder})
endforeach()
