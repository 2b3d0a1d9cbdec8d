# Measures the numbers of the pages again, and reports the sentences that are no longer true:
#   cmake -DBUILD=build/release -P tests/claims.cmake
# A claim consists of a sentence of a page, the command that measures it, a pattern for the number in the command's
# output, and the allowed range. Results of simulations are equal on every machine. Times have a tolerance of a factor
# of two; ratios have the limits in the sentence. It takes about two minutes; nothing else should run at the same
# time.
cmake_minimum_required(VERSION 3.22)
get_filename_component(source ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
if(NOT BUILD)
  set(BUILD ${source}/build/release)
endif()
get_filename_component(enamel ${BUILD}/apps/enamel/enamel ABSOLUTE)
if(NOT EXISTS ${enamel})
  message(FATAL_ERROR "there is no ${enamel}: build it (cmake --preset release, cmake --build --preset release)")
endif()
set(untrue 0)
set(unknown 0)

# Run a command once and return its output.
function(output_of result)
  string(MD5 key "${ARGN}")
  if(NOT DEFINED CACHE{said_${key}})
    execute_process(COMMAND ${enamel} ${ARGN} WORKING_DIRECTORY ${source} OUTPUT_VARIABLE text ERROR_QUIET
      RESULT_VARIABLE status)
    if(NOT status EQUAL 0)
      set(text "")
    endif()
    set(said_${key} "${text}" CACHE INTERNAL "")
  endif()
  set(${result} "$CACHE{said_${key}}" PARENT_SCOPE)
endfunction()

# claim(<page> <sentence> <pattern with one group> <lowest> <highest> <command of enamel>...)
function(claim page sentence pattern low high)
  file(READ ${source}/${page} text)
  string(FIND "${text}" "${sentence}" place)
  if(place EQUAL -1)
    message("not there    ${page}: \"${sentence}\"")
    math(EXPR untrue "${untrue} + 1")
    set(untrue ${untrue} PARENT_SCOPE)
    return()
  endif()
  output_of(said ${ARGN})
  if(NOT said MATCHES "${pattern}")
    message("not measured ${page}: \"${sentence}\": nothing like ${pattern}")
    math(EXPR unknown "${unknown} + 1")
    set(unknown ${unknown} PARENT_SCOPE)
  elseif(CMAKE_MATCH_1 LESS low OR CMAKE_MATCH_1 GREATER high)
    message("NOT TRUE     ${page}: \"${sentence}\": ${CMAKE_MATCH_1} is outside ${low} to ${high}")
    math(EXPR untrue "${untrue} + 1")
    set(untrue ${untrue} PARENT_SCOPE)
  else()
    message("true         ${page}: \"${sentence}\": ${CMAKE_MATCH_1}")
  endif()
endfunction()

# Rows of the table of enamel bench: median, p99, p99.9, goal, ratio, error.
set(number "(-?[0-9][-0-9.e+]*)")
set(skip "[ \t]+[-0-9.e+]+")
set(gap "[ \t]+")
function(row_pattern name column result)
  string(REGEX REPLACE "([][+*().^$?|\\\\])" "\\\\\\1" pattern "${name}")
  foreach(i RANGE 1 ${column})
    if(i LESS column)
      string(APPEND pattern "${skip}")
    endif()
  endforeach()
  set(${result} "\n${pattern}${gap}${number}" PARENT_SCOPE)
endfunction()
macro(claim_bench page sentence row column low high)  # the row's group is the filter
  row_pattern("${row}" ${column} pattern)
  string(REGEX REPLACE ":.*" "" group "${row}")
  claim("${page}" "${sentence}" "${pattern}" ${low} ${high} bench --filter ${group})
endmacro()

# README.md
set(push push --device data/devices/tau-nominal.toml --renderer position-control,hold,impedance --device-damping 4
  --noise 0 --json)
foreach(renderer_range "position-control;372500;373500" "hold;26550;26650" "impedance;3065;3075")
  list(GET renderer_range 0 renderer)
  list(GET renderer_range 1 low)
  list(GET renderer_range 2 high)
  claim(README.md "373, 26.6, 3.07 kN/m" "\"${renderer}\": {[^}]*\"K_z1 \\[N/m\\]\": ${number}" ${low} ${high} ${push})
endforeach()
claim_bench(README.md "2.5 to 3.7 us, 0.6 to 1.2 us, by machine" "tick: whole tick, position-control" 1 1.2 5.0)
claim_bench(README.md "2.5 to 3.7 us, 0.6 to 1.2 us, by machine" "tick: whole tick, hold" 1 0.3 1.2)
claim_bench(README.md "with its guard (0.2 us)" "tick: its guard, hold" 1 0.09 0.36)
claim_bench(README.md "9 to 15 times faster, 8e-15 off" "device: forward dynamics from pose and twist" 5 9 15)
claim_bench(README.md "9 to 15 times faster, 8e-15 off" "device: forward dynamics from pose and twist" 6 0 9e-15)
claim_bench(README.md "within rounding (1e-18 m)" "collision: closest point, haptic path, cache, 100 k" 6 0 1e-18)
claim_bench(README.md "3 to 6 times faster than Embree 3, by machine" "collision: closest point, haptic path, cache, 100 k" 5 3 6)

# lib/docs/measurements.md: trials of position control, lowest and highest values for delays of 0, 1, 2 and 3 ticks.
function(claim_trials sentence row)
  foreach(delay RANGE 3)
    math(EXPR at "2 * ${delay}")
    list(GET ARGN ${at} low)
    math(EXPR at "${at} + 1")
    list(GET ARGN ${at} high)
    claim(lib/docs/measurements.md "${sentence}" "\n${row} +${number}" ${low} ${high} compare
      --device data/devices/tau-nominal.toml --renderers position-control --runs 100 --delays constant:${delay})
  endforeach()
  set(untrue ${untrue} PARENT_SCOPE)
  set(unknown ${unknown} PARENT_SCOPE)
endfunction()
claim_trials("16 | 43 (2100) | 99 (473) | 173 (1170)" "ramp +depth +um" 15.5 16.5 42.5 43.5 98.5 99.5 172.5 173.5)
claim_trials("1.13 | 1.16 (1.32) | 1.13 (1.40) | 1.10 (1.43)" "release +speed over the unavoidable"
  1.125 1.135 1.155 1.165 1.125 1.135 1.095 1.105)
claim_trials("1.02 | 1.01 | 1.01 | 1.01" "release +mean speed over the unavoidable"
  1.015 1.025 1.005 1.015 1.005 1.015 1.005 1.015)
claim_trials("0.001 | 0.06 (20) | 0.13 (20) | 0.19 (20)" "slide +tangential force +%" 0.0005 0.0015 0.055 0.065 0.125 0.135
  0.185 0.195)
claim_trials("5 | 15 (16) | 28 (32) | 38 (56)" "slide +rms depth +um" 4.5 5.5 15 15.5 27.5 28.5 37 38.5)
claim_trials("43 | 84 | 129 | 238" "impact 0.05 m/s +bounce +um" 42 44 83 85 128 130 237 239)
claim_trials("34 | 76 | 116 | 180" "impact 0.5 m/s +bounce +um" 33 35 75 77 115 117 179 181)
claim_trials("76 | 84 | 67 | 47" "impact 0.05 m/s +extended rate-hardness +kN/m" 75.5 76.5 83.5 84.5 66.5 67.5 46.5 47.5)
claim_trials("132 | 116 | 123 | 113" "impact 0.5 m/s +extended rate-hardness +kN/m" 131.5 132.5 115.5 116.5 122.5 123.5
  112.5 113.5)
claim_trials("79 | 141 (708) | 283 (2790) | 534 (6570)" "overload +bounce +um" 78 80 140 142 282 284 533 535)

# lib/docs/taps.md: match to enamel on the TAU nominal at delays of 0, 1 and 2 ticks.
foreach(claimed "0;plain;32.5;33.5" "1;plain;25.5;26.5" "2;plain;23.5;24.5" "0;transient;75.5;76.5"
    "1;transient;75.5;76.5" "2;transient;74.5;75.5")
  list(POP_FRONT claimed delay task low high)
  claim(lib/docs/taps.md "33 -> 76 | 26 -> 76 | 24 -> 75" "\ntap ${task} +mean match +% +${number}" ${low} ${high} compare
    --device data/devices/tau-nominal.toml --tasks tap --renderers position-control --delays constant:${delay})
endforeach()

if(untrue OR unknown)
  message(FATAL_ERROR "${untrue} sentences are not true, ${unknown} were not measured")
endif()
message("every sentence is true")
