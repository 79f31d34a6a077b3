# Defines the target pipescout_class_loader: class_loader as Debian ships it. Debian's own
# class_loaderConfig.cmake asks for parts of ament that Debian does not have.
if(NOT TARGET pipescout_class_loader)
  find_library(CLASS_LOADER_LIBRARY class_loader REQUIRED)
  find_library(CONSOLE_BRIDGE_LIBRARY console_bridge REQUIRED)
  find_path(CLASS_LOADER_INCLUDE_DIR class_loader/class_loader.hpp PATH_SUFFIXES class_loader REQUIRED)
  find_path(RCPPUTILS_INCLUDE_DIR rcpputils/filesystem_helper.hpp PATH_SUFFIXES rcpputils REQUIRED)
  find_path(RCUTILS_INCLUDE_DIR rcutils/types.h PATH_SUFFIXES rcutils REQUIRED)
  add_library(pipescout_class_loader INTERFACE IMPORTED GLOBAL)
  target_include_directories(pipescout_class_loader SYSTEM INTERFACE
    ${CLASS_LOADER_INCLUDE_DIR} ${RCPPUTILS_INCLUDE_DIR} ${RCUTILS_INCLUDE_DIR})
  target_link_libraries(pipescout_class_loader INTERFACE
    ${CLASS_LOADER_LIBRARY} ${CONSOLE_BRIDGE_LIBRARY})
endif()
