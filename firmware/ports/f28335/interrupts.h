/* Interrupt vectors. Never compiled by TI's compiler. */
#ifndef HB_INTERRUPTS_H
#define HB_INTERRUPTS_H

#include "compiler.h"

/* Sets the two handlers, and otherwise for all other vectors; enables the two interrupts. They are
 * not served before HB_ENABLE_INTERRUPTS. */
void hb_interrupts_start(hb_handler control, hb_handler receive, hb_handler otherwise);

/* At the end of a handler: acknowledges the group of the control or the receive interrupt. */
void hb_control_handled(void);
void hb_receive_handled(void);

void hb_mask_control(void);
void hb_unmask_control(void);

#endif
