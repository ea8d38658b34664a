/* The firmware on the F28335. Never compiled by TI's compiler. */
#ifndef HB_BOARD_H
#define HB_BOARD_H

#include "types.h"

/* Starts the board, up to enabling interrupts. The valves are neutral from its first microseconds
 * on. False: the board cannot run (no oscillator, McBSP failure); the valves are neutral. */
bool hb_board_start(void);

/* One iteration of the idle loop. */
void hb_board_idle(void);

/* Sets the valves to neutral and waits for the reset by the watchdog. */
void hb_board_stop(void);

#endif
