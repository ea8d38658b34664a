/* The table of interrupts. Never compiled by TI's compiler. */
#ifndef HB_INTERRUPTS_H
#define HB_INTERRUPTS_H

#include "compiler.h"

/* All vectors at otherwise but for the two, and the two enabled, though not let through before
 * HB_ENABLE_INTERRUPTS. */
void hb_interrupts_start(hb_handler control, hb_handler receive, hb_handler otherwise);

/* At a handler's end: lets the group of the control interrupt or of the receiver come again. */
void hb_control_handled(void);
void hb_receive_handled(void);

void hb_mask_control(void);
void hb_unmask_control(void);

#endif
