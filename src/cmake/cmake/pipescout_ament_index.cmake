# SPDX-License-Identifier: Apache-2.0

# pipescout_index_package()
#
# Enters the package into the ament index, by which `ros2 pkg`, `ros2 run` and `ros2 launch` find it:
#   <prefix>/share/ament_index/resource_index/packages/<project>, and share/<project>/package.xml.
# Installs the environment hook share/<project>/environment/ament_prefix_path.sh, too: a workspace has
# its packages in AMENT_PREFIX_PATH when one of them names it under "hooks" in its colcon.pkg.
# pipescout_export_package() calls it.
function(pipescout_index_package)
  pipescout_index_resource(packages ${PROJECT_NAME} "")
  install(FILES package.xml DESTINATION share/${PROJECT_NAME})
  install(FILES ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../environment/ament_prefix_path.sh
    DESTINATION share/${PROJECT_NAME}/environment)
endfunction()

# pipescout_index_resource(<type> <name> <content>)
#
# An entry of the ament index: <prefix>/share/ament_index/resource_index/<type>/<name>. The content may
# hold generator expressions.
function(pipescout_index_resource type name content)
  set(file ${CMAKE_CURRENT_BINARY_DIR}/ament_index/${type}/${name})
  file(GENERATE OUTPUT ${file} CONTENT "${content}")
  install(FILES ${file} DESTINATION share/ament_index/resource_index/${type})
endfunction()

# The executable as lib/<project>/<name>, where `ros2 run` looks for it. It stays in bin/ for people.
function(_pipescout_index_executable target)
  set(link "\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/${PROJECT_NAME}")
  install(CODE "
    file(MAKE_DIRECTORY \"${link}\")
    file(CREATE_LINK ../../${CMAKE_INSTALL_BINDIR}/$<TARGET_FILE_NAME:${target}>
      \"${link}/$<TARGET_FILE_NAME:${target}>\" SYMBOLIC)")
endfunction()
