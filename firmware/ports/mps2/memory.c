/* What a compiler may call wherever it copies or clears a struct; without a C library it is here.
 * Compiled so that it is not turned into calls of itself (see the Makefile). */
#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count);
void *memset(void *to, int value, size_t count);

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    unsigned char *out = to;
    const unsigned char *in = from;

    while (count-- > 0u) {
        *out++ = *in++;
    }
    return to;
}

void *memset(void *to, int value, size_t count)
{
    unsigned char *out = to;

    while (count-- > 0u) {
        *out++ = (unsigned char)value;
    }
    return to;
}
