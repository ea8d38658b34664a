/* The firmware on the F28335. Never compiled by TI's compiler. */
#ifndef HB_BOARD_H
#define HB_BOARD_H

#include "types.h"

/* From reset to interrupts on; the valves are neutral from its first microseconds on. False: the
 * board can't run (no oscillator, the McBSP dead); the valves are neutral. */
bool hb_board_start(void);

/* One round of the idle loop. */
void hb_board_idle(void);

/* Valves neutral, then for ever until the watchdog resets the board. */
void hb_board_stop(void);

#endif
