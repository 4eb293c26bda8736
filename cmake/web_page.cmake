# The page of `trunnion report`, bundled from web/ into a source file of the room report. It takes Node.js and the packages
# of web/package-lock.json, which scripts/install_dependencies.sh installs; without them the program builds too, and
# `report` says what is missing (REP0001).
set(web_dir ${PROJECT_SOURCE_DIR}/web)
set(web_page_source ${PROJECT_BINARY_DIR}/web/web_page.cpp)
# Looked at again when packages come or go.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${web_dir})
find_program(TRUNNION_NODE node)

set(web_page_missing "")
if(NOT TRUNNION_NODE)
  set(web_page_missing "Node.js was not there when it was built")
elseif(NOT EXISTS ${web_dir}/node_modules/esbuild)
  set(web_page_missing "the packages of web/package-lock.json were not there when it was built")
endif()

if(web_page_missing)
  message(STATUS "Without the page of `trunnion report`: ${web_page_missing}")
  configure_file(${CMAKE_CURRENT_LIST_DIR}/web_page_missing.cpp.in ${PROJECT_BINARY_DIR}/web/web_page_missing.cpp @ONLY)
  set(web_page_source ${PROJECT_BINARY_DIR}/web/web_page_missing.cpp)
else()
  file(GLOB web_sources CONFIGURE_DEPENDS ${web_dir}/src/*)
  add_custom_command(OUTPUT ${web_page_source}
    COMMAND ${TRUNNION_NODE} ${web_dir}/bundle.mjs ${web_page_source}
    DEPENDS ${web_sources} ${web_dir}/bundle.mjs ${web_dir}/package-lock.json
    COMMENT "Bundling the page of trunnion report" VERBATIM)
endif()
set_source_files_properties(${web_page_source} TARGET_DIRECTORY trunnion_report PROPERTIES COMPILE_OPTIONS -Wno-overlength-strings)
target_sources(trunnion_report PRIVATE ${web_page_source})
