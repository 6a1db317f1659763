# headframe_page(directory files): the page of server/operator/web, built by node into `directory`; `files` becomes the list of
# what lies there afterwards, empty without node. Names are known beforehand, so that the build needs no second configure.
option(HEADFRAME_PAGE "Build the operator's page, which needs node 18 and npm" ON)

function(headframe_page directory files)
  set(${files} "" PARENT_SCOPE)
  find_program(NODE node)
  find_program(NPM npm)
  set(why "")
  if(NOT HEADFRAME_PAGE)
    set(why "HEADFRAME_PAGE is off")
  elseif(NOT NODE OR NOT NPM)
    set(why "node or npm is missing")
  else()
    execute_process(COMMAND ${NODE} --version OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT version MATCHES "^v(1[89]|[2-9][0-9])\\.")
      set(why "node is ${version}, and 18 is needed")
    endif()
  endif()
  if(why)
    message(STATUS "The server is built without the operator's page: ${why}")
    return()
  endif()
  set(web ${CMAKE_CURRENT_SOURCE_DIR}/operator/web)
  set(installed ${web}/node_modules/.package-lock.json)  # npm's own
  add_custom_command(OUTPUT ${installed}
    COMMAND ${NPM} ci --ignore-scripts --no-progress --loglevel=error
    DEPENDS ${web}/package.json ${web}/package-lock.json ${web}/.npmrc
    WORKING_DIRECTORY ${web} COMMENT "Fetching what the operator's page is built with (-DHEADFRAME_PAGE=OFF: no page)" VERBATIM)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${web}/src/*)
  set(built ${directory}/index.html.gz ${directory}/page.js.gz ${directory}/page.css.gz ${directory}/page.woff2)
  add_custom_command(OUTPUT ${built}
    COMMAND ${NPM} run --silent build -- --outDir ${directory} --logLevel warn
    DEPENDS ${installed} ${sources} ${web}/index.html ${web}/tsconfig.json ${web}/vite.config.js
    WORKING_DIRECTORY ${web} COMMENT "Building the operator's page" VERBATIM)
  set(${files} ${built} PARENT_SCOPE)
endfunction()
