/* The functions that a compiler may call to copy or clear a struct; there is no C library. An
 * option of each build file prevents the compiler from turning their loops into calls of
 * themselves. */
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
