/* State of the board on the Nucleo's LED (PA5) and on an external one (PC8). Never run on hardware.
 *
 * | state | LED |
 * |---|---|
 * | at rest | one short flash a second |
 * | schedule running | on |
 * | fault | four flashes a second |
 * | emergency stop pressed | two short flashes a second |
 * | stopped or not started | off */
#ifndef STM32F4_LED_H
#define STM32F4_LED_H

#include "types.h"

void led_start(void);

/* In each tick. state: enum hb_state. */
void led_tick(hb_u16 state, bool emergency_stop);

#endif
