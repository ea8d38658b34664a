/* The requests of the dictionary. Each may arrive twice without harm: the host repeats a request
 * whose reply it missed. */
#ifndef HB_COMMANDS_H
#define HB_COMMANDS_H

#include "core.h"
#include "octets.h"
#include "wire.h"

/* Executes a request and writes the payload of its reply; returns the refusal or HB_REFUSAL_NONE.
 * A refused request changes nothing. */
hb_u16 hb_command(hb_core *core, const hb_frame *frame, hb_writer *reply);

#endif
