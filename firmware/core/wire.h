/* Frames on the wire: [sequence][type][payload][CRC-16 little-endian], COBS-stuffed so that no
 * octet of it is zero, and ended by a zero octet. A damaged frame is dropped without a word (the
 * host asks again); the next zero octet is the next frame's start. */
#ifndef HB_WIRE_H
#define HB_WIRE_H

#include "dictionary.h"
#include "types.h"

#define HB_FRAME_OVERHEAD 4u                     /* sequence, type, CRC */
#define HB_MAX_PAYLOAD (HB_MAX_FRAME - HB_FRAME_OVERHEAD)
#define HB_MAX_STUFFED (HB_MAX_FRAME + 1u)       /* a frame of 254 octets gains one */
#define HB_MAX_ON_WIRE (HB_MAX_STUFFED + 1u)     /* and its end mark */

HB_ASSERT(frame_gains_one_octet, HB_MAX_FRAME <= 254u);

/* COBS. out must have room for count + count / 254 + 1 octets; returns how many it got. */
hb_u16 hb_cobs_encode(const hb_octet *in, hb_u16 count, hb_octet *out);
/* Works in place too (in == out). Returns the number of octets, 0 if they are no COBS block. */
hb_u16 hb_cobs_decode(const hb_octet *in, hb_u16 count, hb_octet *out);

typedef struct {
    hb_octet octets[HB_MAX_STUFFED]; /* stuffed while they come in, then plain */
    hb_u16 count;
    bool too_long; /* skipping to the next end mark */
} hb_receiver;

typedef struct {
    hb_octet sequence;
    hb_octet type;
    const hb_octet *payload; /* valid until the receiver gets its next octet */
    hb_u16 count;
} hb_frame;

/* Takes one octet; true if it completes a sound frame, which is then in *frame. */
bool hb_receive(hb_receiver *receiver, hb_octet octet, hb_frame *frame);

/* True if the octet ends a line of '?' alone, typed since the last end mark. Any typed line is
 * forgotten with its end. The host's frames don't look so: their first octet, COBS's distance to the first
 * zero, is at most 9, for a request without payload has 4 octets, "start" has 8, and each other one
 * has a zero in its high octet of an index or count. So none begins with '?' (63), CR (13) or LF
 * (10), which stands there where a terminal ended the line before with both. */
bool hb_receive_question(hb_receiver *receiver, hb_octet octet);

/* Completes a frame whose payload of count octets stands in plain from its third octet on, and
 * stuffs it into out (HB_MAX_ON_WIRE octets), end mark included. Returns the octets in out. */
hb_u16 hb_encode_frame(hb_octet sequence, hb_octet type, hb_octet plain[HB_MAX_FRAME],
                       hb_u16 count, hb_octet *out);

#endif
