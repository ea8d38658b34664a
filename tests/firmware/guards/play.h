/* Functions that play.c needs from its platform (play_on.c). The compiler's options define
 * PLAY_STATES, PLAY_PHASES and PLAY_FAULTS, the sizes of the dictionary's tables. */
#ifndef PLAY_H
#define PLAY_H

#include <stdbool.h>

void play(void);

/* True before the end of the script; its next octet, 0 after the end. */
bool play_more(void);
unsigned play_next(void);

void play_output(unsigned octet);

/* False after the number of ticks that a fuzzer allows each script. */
bool play_may_tick(void);

/* Ends the program with an error. */
void play_fail(const char *what);

#define PLAY_CHECK(what) ((what) ? (void)0 : play_fail(#what))

#endif
