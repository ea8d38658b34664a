/* Monitor of the 3.3 V. Never run on hardware. */
#ifndef STM32F4_SUPPLY_H
#define STM32F4_SUPPLY_H

#include <stdbool.h>

/* Starts the interrupt that stops the board as the supply falls below about 2.9 V. Below 1.7 V the
 * chip holds itself in reset, which cuts the outputs. */
void supply_start(void);
/* The supply was low from the start on, which raises no interrupt. */
bool supply_is_low(void);

#endif
