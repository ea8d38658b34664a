/* The link to the host: receives requests, has them executed and sends the replies. Used by the
 * idle loop only (hb_link_poll in hal.h). */
#ifndef HB_LINK_H
#define HB_LINK_H

#include "core.h"
#include "wire.h"

struct hb_link {
    hb_core *core;
    hb_receiver receiver;
    hb_octet reply[HB_MAX_FRAME];
    hb_octet out[HB_MAX_ON_WIRE];
    hb_u16 out_count;
    hb_u16 out_sent;
};

#endif
