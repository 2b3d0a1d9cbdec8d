# enamel_add_plugin(<target> <sources>...): a renderer plugin, <target>.so. Only enamel_plugin() is exported: everything
# else, also from static libraries and templates of the standard library, stays inside.
set(ENAMEL_PLUGIN_EXPORTS ${CMAKE_CURRENT_LIST_DIR}/plugin.exports)

function(enamel_add_plugin target)
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES PREFIX "" C_STANDARD 11 CXX_STANDARD 17
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    LINK_DEPENDS ${ENAMEL_PLUGIN_EXPORTS})
  target_link_libraries(${target} PRIVATE enamel::abi m)
  # A symbol that is missing is refused here, not by the host.
  target_link_options(${target} PRIVATE -Wl,--version-script=${ENAMEL_PLUGIN_EXPORTS} -Wl,--no-undefined)
endfunction()
