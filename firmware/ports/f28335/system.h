/* Clocks, the free microsecond counter and the watchdog. Never compiled by TI's compiler. */
#ifndef HB_SYSTEM_H
#define HB_SYSTEM_H

#include "types.h"

#define HB_SYSCLK_HZ 150000000UL
#define HB_LSPCLK_HZ 37500000UL /* SCI and McBSP */

/* Enables the modules' clocks and starts the counter. The processor runs at a few MHz until
 * hb_clock_start. */
void hb_modules_start(void);
/* 30 MHz x 10 / 2. False: no oscillator, or no lock of the PLL. */
bool hb_clock_start(void);

/* Microseconds at 150 MHz, longer before hb_clock_start; wraps at 65536. */
hb_u16 hb_microseconds(void);
void hb_wait(hb_u16 microseconds);

void hb_watchdog_start(void);
void hb_watchdog_service(void);

#endif
