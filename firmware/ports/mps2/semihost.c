#include "semihost.h"

#define SYS_OPEN 0x01u
#define SYS_WRITE 0x05u
#define SYS_READ 0x06u
#define SYS_EXIT 0x18u
#define OPEN_READ 0u
#define OPEN_WRITE 4u
#define STOPPED_APPLICATION_EXIT 0x20026u
#define STOPPED_RUNTIME_ERROR 0x20023u

/* An address as a word of a parameter block. */
static uint32_t word_of(const void *pointer)
{
    return (uint32_t)pointer;
}

static uint32_t call(uint32_t operation, uint32_t parameter)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uint32_t r1 __asm__("r1") = parameter;

    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static int32_t open(uint32_t mode)
{
    static const char name[] = ":tt"; /* standard input or output, by the mode */
    const uint32_t block[3] = {word_of(name), mode, sizeof name - 1u};

    return (int32_t)call(SYS_OPEN, word_of(block));
}

int32_t semihost_open_input(void)
{
    return open(OPEN_READ);
}

int32_t semihost_open_output(void)
{
    return open(OPEN_WRITE);
}

/* Both calls return the number of octets left; no progress: the other side has ended. */
static bool transfer(uint32_t operation, int32_t handle, uint32_t address, uint32_t count)
{
    while (count > 0u) {
        const uint32_t block[3] = {(uint32_t)handle, address, count};
        const uint32_t left = call(operation, word_of(block));
        if (left >= count) {
            return false;
        }
        address += count - left;
        count = left;
    }
    return true;
}

bool semihost_read(int32_t handle, void *data, uint32_t count)
{
    return transfer(SYS_READ, handle, word_of(data), count);
}

bool semihost_write(int32_t handle, const void *data, uint32_t count)
{
    return transfer(SYS_WRITE, handle, word_of(data), count);
}

void semihost_exit(int32_t code)
{
    for (;;) {
        (void)call(SYS_EXIT, code == 0 ? STOPPED_APPLICATION_EXIT : STOPPED_RUNTIME_ERROR);
    }
}
