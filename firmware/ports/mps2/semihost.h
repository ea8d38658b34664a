/* Semihosting (ARM IHI 0084): input and output through the emulator. */
#ifndef MPS2_SEMIHOST_H
#define MPS2_SEMIHOST_H

#include <stdbool.h>
#include <stdint.h>

/* Handles of the emulator's standard input and output; negative on failure. */
int32_t semihost_open_input(void);
int32_t semihost_open_output(void);

/* Waits for count octets; false at the end of the input. */
bool semihost_read(int32_t handle, void *data, uint32_t count);
bool semihost_write(int32_t handle, const void *data, uint32_t count);

/* Ends the emulator; its exit code is 0 for 0, else 1. */
void semihost_exit(int32_t code);

#endif
