/* What play.c asks of the place where it runs (play_on.c), and its limits. PLAY_STATES,
 * PLAY_PHASES and PLAY_FAULTS, how many there are, come from the dictionary with the compiler's
 * command. */
#ifndef PLAY_H
#define PLAY_H

#include <stdbool.h>

void play(void);

/* The script has not ended; its next octet, 0 after its end. */
bool play_more(void);
unsigned play_next(void);

void play_say(unsigned octet);

/* A fuzzer allows each script so many ticks. */
bool play_may_tick(void);

/* Ends the program with an error. */
void play_broken(const char *what);

#define PLAY_CHECK(what) ((what) ? (void)0 : play_broken(#what))

#endif
