# Options of the ports without operating system and C library. A port sets HB_CPU, the options of its
# processor, and includes this file.

# No fused multiply-add: the same bits here as on a host. No loops turned into calls of memcpy and
# memset, which are loops themselves (memory.c). The call graphs give a bound of the stack.
add_compile_options(${HB_CPU} -O2 -g
  -ffreestanding -ffp-contract=off -ffunction-sections -fdata-sections
  -fno-tree-loop-distribute-patterns -fcallgraph-info=su
  -Wall -Wextra -Wconversion -Wsign-conversion -Wdouble-promotion -Wstrict-prototypes
  -Wmissing-prototypes -Wshadow -Werror)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_STANDARD_REQUIRED ON)
include_directories(${PROJECT_SOURCE_DIR}/core ${CMAKE_CURRENT_LIST_DIR})

file(GLOB HB_CORE CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/core/*.c)
list(APPEND HB_CORE ${CMAKE_CURRENT_LIST_DIR}/memory.c)

# NAME.elf, .bin and .hex in the build folder, linked by the port's link.ld.
function(hb_image name)
  add_executable(${name} ${ARGN})
  target_link_options(${name} PRIVATE ${HB_CPU} -nostdlib -T ${CMAKE_CURRENT_SOURCE_DIR}/link.ld
    -Wl,--gc-sections -Wl,--fatal-warnings)
  target_link_libraries(${name} PRIVATE gcc)
  set_target_properties(${name} PROPERTIES SUFFIX .elf
    LINK_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/link.ld
    RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${name}> ${PROJECT_BINARY_DIR}/${name}.bin
    COMMAND ${CMAKE_OBJCOPY} -O ihex $<TARGET_FILE:${name}> ${PROJECT_BINARY_DIR}/${name}.hex
    COMMAND ${CMAKE_SIZE} $<TARGET_FILE:${name}>)
endfunction()
