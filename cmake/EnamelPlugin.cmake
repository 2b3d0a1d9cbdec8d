# enamel_add_plugin(<target> <sources>...): add a plugin, <target>.so, on Windows <target>.dll. It exports
# enamel_plugin() (a renderer) or enamel_driver() only. All other symbols remain inside, also those of static libraries
# and of templates of the standard library.
set(ENAMEL_PLUGIN_EXPORTS ${CMAKE_CURRENT_LIST_DIR}/plugin.exports)

function(enamel_add_plugin target)
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES PREFIX "" C_STANDARD 11 CXX_STANDARD 17
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LINK_DEPENDS ${ENAMEL_PLUGIN_EXPORTS})
  target_link_libraries(${target} PRIVATE enamel::abi)
  if(NOT WIN32)  # there ENAMEL_PLUGIN_EXPORT is enough
    # Report a missing symbol here rather than in the host.
    target_link_options(${target} PRIVATE -Wl,--version-script=${ENAMEL_PLUGIN_EXPORTS} -Wl,--no-undefined)
    target_link_libraries(${target} PRIVATE m)
  endif()
endfunction()
