/* What the board does with each request of the dictionary. Every request may come twice without
 * harm: the host sends it again when it got no reply. */
#ifndef HB_COMMANDS_H
#define HB_COMMANDS_H

#include "core.h"
#include "octets.h"

/* Carries out a request and writes its reply's payload; returns a refusal or HB_REFUSAL_NONE.
 * After a refusal nothing has changed. */
hb_u16 hb_command(hb_core *core, const hb_frame *frame, hb_writer *reply);

#endif
