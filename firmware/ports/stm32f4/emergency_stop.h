/* Emergency stop, and the pin that releases the valve outputs. Never run on hardware.
 *
 * The release (PB1, with a pull-down) reaches the outputs only through a normally closed contact of
 * the emergency stop: the contact cuts them without software. A second contact, from PA6 to ground,
 * reports it; PA6 also cuts the pulse-width output by the break input of timer 1. */
#ifndef STM32F4_EMERGENCY_STOP_H
#define STM32F4_EMERGENCY_STOP_H

#include <stdbool.h>

/* The outputs are cut from the reset until outputs_release. */
void emergency_stop_start(void);
void outputs_release(void);
void outputs_cut(void);

/* The button is pressed, or its wire is broken. */
bool emergency_stop_is_pressed(void);

#endif
