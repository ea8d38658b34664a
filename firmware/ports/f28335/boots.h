/* The number of starts, kept through resets. Never compiled by TI's compiler. */
#ifndef HB_BOOTS_H
#define HB_BOOTS_H

#include "types.h"

/* Counts this start. After a reset: one more than before. After power-up, when the count's
 * complement beside it doesn't fit: a number that follows from what the RAM held by chance. That
 * one may, seldom, be the number from before. */
hb_u16 hb_boots(void);

#endif
