/* Platforms of play.c: desktop, AVR under simavr (avr.c), fuzzer. */
#include "play.h"

#ifdef __AVR__

#include <avr/io.h>

/* General-purpose registers that avr.c monitors. */
bool play_more(void)
{
    return GPIOR2 != 0;
}

unsigned play_next(void)
{
    return GPIOR0;
}

void play_output(unsigned octet)
{
    GPIOR1 = (unsigned char)octet;
}

bool play_may_tick(void)
{
    return true;
}

void play_fail(const char *what)
{
    while (*what != '\0') {
        play_output((unsigned char)*what++);
    }
    GPIOR2 = 1;
    for (;;) {
    }
}

int main(void)
{
    play();
    GPIOR2 = 0;
    for (;;) {
    }
}

#else

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

void play_fail(const char *what)
{
    fprintf(stderr, "violated: %s\n", what);
    abort();
}

#ifdef PLAY_FUZZ

#define MAX_TICKS 4000u

static const uint8_t *script;
static size_t left;
static unsigned ticks;

bool play_more(void)
{
    return left > 0u;
}

unsigned play_next(void)
{
    return left > 0u ? (left--, *script++) : 0u;
}

void play_output(unsigned octet)
{
    (void)octet;
}

bool play_may_tick(void)
{
    return ticks++ < MAX_TICKS;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    script = data;
    left = size;
    ticks = 0;
    play();
    return 0;
}

#else

bool play_more(void)
{
    const int octet = getchar();

    ungetc(octet, stdin);
    return octet != EOF;
}

unsigned play_next(void)
{
    const int octet = getchar();
    return octet == EOF ? 0u : (unsigned)octet;
}

void play_output(unsigned octet)
{
    putchar((int)octet);
}

bool play_may_tick(void)
{
    return true;
}

int main(void)
{
    play();
    return 0;
}

#endif
#endif
