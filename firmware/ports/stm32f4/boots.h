/* The number of starts, preserved through resets. Never run on hardware. */
#ifndef STM32F4_BOOTS_H
#define STM32F4_BOOTS_H

#include "types.h"

/* Counts this start and returns the number: after a reset one more than before; after power-up,
 * recognised by a wrong complement of the count, a CRC of the RAM's random contents, which may
 * rarely equal the previous number. */
hb_u16 boots_count(void);

#endif
